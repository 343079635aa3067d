// A BTF sample in factors: image i of a group is the sum over k of directions[i, k] · eigentextures[k].

// Splits the buffer into groups. Eigentextures are whole numbers of `step`, stored as low bytes, then high bytes, with
// the sign in the lowest bit.
export function unpackSample({ step, groups, width, height }, buffer) {
  const numbers = 3 * width * height;
  let at = 0;
  return groups.map(({ images, rank }) => {
    const directions = Float32Array.from(new Int16Array(buffer.slice(at, at + 2 * images * rank)), (v) => v / 32767);
    at += 2 * images * rank;
    const low = new Uint8Array(buffer, at, rank * numbers);
    const high = new Uint8Array(buffer, at + rank * numbers, rank * numbers);
    at += 2 * rank * numbers;
    const eigentextures = new Float32Array(rank * numbers);
    for (let i = 0; i < eigentextures.length; i++) {
      const folded = low[i] | (high[i] << 8);
      eigentextures[i] = step * ((folded >> 1) ^ -(folded & 1));
    }
    return { images, rank, directions, eigentextures, numbers };
  });
}

// Adds up eigentextures by weights into `out`: linear radiance, red to blue per texel, row by row from the top.
export function mix(group, weights, out) {
  out.fill(0);
  for (let k = 0; k < group.rank; k++) {
    const weight = weights[k], from = k * group.numbers;
    if (weight === 0) continue;
    for (let i = 0; i < group.numbers; i++) out[i] += weight * group.eigentextures[from + i];
  }
  for (let i = 0; i < out.length; i++) if (out[i] < 0) out[i] = 0;
  return out;
}

// The factors of one image.
export function weightsOf(group, image) {
  return group.directions.subarray(image * group.rank, (image + 1) * group.rank);
}

// The factors of a weighted sum of a group's images.
export function weightsOfSum(group, shares) {
  const sum = new Float32Array(group.rank);
  shares.forEach((share, image) => {
    weightsOf(group, image).forEach((weight, k) => {
      sum[k] += share * weight;
    });
  });
  return sum;
}

// 8-bit sRGB of a linear value.
export function srgb(linear) {
  const x = Math.min(1, Math.max(0, linear));
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
}
