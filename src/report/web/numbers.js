// Numbers that a page carries: gzip in base64, in script elements of type text/plain.

function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// The buffer of a script element; the element is emptied, as its text is large.
export async function readNumbers(id) {
  const element = document.getElementById(id);
  const packed = new Blob([bytesOfBase64(element.textContent.trim())]);
  element.textContent = "";
  const unpacked = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(unpacked).arrayBuffer();
}

export function readDescription(id) {
  return JSON.parse(document.getElementById(id).textContent);
}
