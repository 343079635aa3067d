// WebGL 2: programs, textures and targets.

export function program(gl, vertexText, fragmentText, defines = {}) {
  const lines = Object.entries(defines).map(([name, value]) => `#define ${name} ${value}\n`).join("");
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text.trim().replace("\n", `\n${lines}`));
    gl.compileShader(shader);
    gl.attachShader(made, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
    const { name, type } = gl.getActiveUniform(made, i);
    places[name] = { place: gl.getUniformLocation(made, name), type };
  }
  return { made, places };
}

// Sets uniforms by name; textures take units in their order. Names that the shader does not use are passed over.
export function use(gl, { made, places }, values, textures) {
  gl.useProgram(made);
  for (const [name, value] of Object.entries(values)) {
    const uniform = places[name];
    if (!uniform) continue;
    const { place, type } = uniform;
    if (type === gl.FLOAT) gl.uniform1f(place, value);
    else if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, value);
    else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, value);
    else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(place, false, value);
    else if (type === gl.INT_VEC2) gl.uniform2iv(place, value);
    else gl.uniform1i(place, value);
  }
  Object.entries(textures).forEach(([name, { kind, texture }], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, texture);
    if (places[name]) gl.uniform1i(places[name].place, unit);
  });
}

function empty(gl, kind, filter) {
  const texture = gl.createTexture();
  gl.bindTexture(kind, texture);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(kind, name, filter);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(kind, name, gl.CLAMP_TO_EDGE);
  return { kind, texture };
}

// A table of numbers, read one by one; `format` names the internal format, the layout and the type.
export function table(gl, [internal, layout, type], width, height, data) {
  const made = empty(gl, gl.TEXTURE_2D, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, layout, type, data);
  return made;
}

// Layers of equal size, filled later.
export function layers(gl, internal, width, height, depth, filter) {
  const made = empty(gl, gl.TEXTURE_2D_ARRAY, filter);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, internal, width, height, depth);
  return made;
}

// A target that draws into all layers at once.
export function targetOfLayers(gl, { texture }, depth) {
  const target = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  const places = Array.from({ length: depth }, (_, layer) => gl.COLOR_ATTACHMENT0 + layer);
  places.forEach((place, layer) => {
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, place, texture, 0, layer);
  });
  gl.drawBuffers(places);
  return target;
}
