// The sample's images as tiles of a layered texture, multiplied out from their factors. A layer is a view, its tiles are
// lights, the last one the image under an even environment. Tiles have a border of a texel for filtering.

import { layers } from "./textures.js";
import { mix, weightsOf, weightsOfSum } from "./sample.js";

const TILES_OF_SCATTERED = 64;

export function layout(about) {
  const tiles = about.scattered ? TILES_OF_SCATTERED : about.groups[0].images + 1;
  const tilesAcross = Math.ceil(Math.sqrt(tiles)); // 8 for scattered ones: see shade.frag.
  const depth = about.scattered ? Math.ceil(about.groups[0].images / tiles) : about.groups.length;
  return {
    tiles, tilesAcross, depth,
    width: tilesAcross * (about.width + 2), height: Math.ceil(tiles / tilesAcross) * (about.height + 2),
  };
}

const floats = new Float32Array(1), bits = new Uint32Array(floats.buffer);

// Shared exponent: three mantissas of 9 bits.
function sharedExponent(r, g, b) {
  floats[0] = Math.max(r, g, b, 2 ** -15);
  const exponent = Math.max(0, (bits[0] >>> 23) - 127 + 16);
  const scale = 2 ** (24 - exponent);
  const top = Math.round(Math.max(r, g, b) * scale) > 511 ? 1 : 0;
  const part = (v) => Math.min(511, Math.round(v * (top ? scale / 2 : scale)));
  return ((exponent + top) << 27) | (part(b) << 18) | (part(g) << 9) | part(r);
}

// Puts an image into its tile of a layer, with the border that wraps or repeats.
function place(layer, { width: layerWidth, tilesAcross }, { width, height, tileable }, tile, numbers) {
  const left = (tile % tilesAcross) * (width + 2), top = Math.floor(tile / tilesAcross) * (height + 2);
  const inside = (at, side) => (tileable ? (at + side) % side : Math.max(0, Math.min(side - 1, at)));
  for (let row = 0; row < height; row++) {
    const to = (top + row + 1) * layerWidth + left + 1;
    for (let column = 0; column < width; column++) {
      const from = 3 * (row * width + column);
      layer[to + column] = sharedExponent(numbers[from], numbers[from + 1], numbers[from + 2]);
    }
    layer[to - 1] = layer[to + inside(-1, width)];
    layer[to + width] = layer[to + inside(width, width)];
  }
  for (const row of [-1, height]) {
    const from = (top + inside(row, height) + 1) * layerWidth + left;
    layer.copyWithin((top + row + 1) * layerWidth + left, from, from + width + 2);
  }
}

// Makes the texture layer by layer; `told` is called with the share that is done.
export async function imageTexture(gl, about, groups, told) {
  const shape = layout(about);
  const texture = layers(gl, gl.RGB9_E5, shape.width, shape.height, shape.depth, gl.LINEAR);
  const numbers = new Float32Array(3 * about.width * about.height);
  for (let depth = 0; depth < shape.depth; depth++) {
    const layer = new Uint32Array(shape.width * shape.height);
    const group = groups[about.scattered ? 0 : depth];
    const first = about.scattered ? depth * shape.tiles : 0;
    const count = Math.min(shape.tiles, group.images - first);
    for (let tile = 0; tile < count; tile++) {
      place(layer, shape, about, tile, mix(group, weightsOf(group, first + tile), numbers));
    }
    if (!about.scattered) {
      place(layer, shape, about, count, mix(group, weightsOfSum(group, about.evenLight), numbers));
    }
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture.texture);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, depth, shape.width, shape.height, 1, gl.RGB,
      gl.UNSIGNED_INT_5_9_9_9_REV, layer);
    told((depth + 1) / shape.depth);
    await new Promise((done) => setTimeout(done));
  }
  return { texture, shape };
}
