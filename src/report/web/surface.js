// The decorated surface: columns of whole numbers → positions, frames and texture coordinates.

import { cross, dot, times, unit } from "./vectors.js";

// Columns are stored as differences to the number before, the sign in the lowest bit, byte by byte.
class Columns {
  constructor(buffer) {
    this.buffer = buffer;
    this.at = 0;
  }

  read(count, bytes) {
    const found = bytes === 2 ? new Uint16Array(count) : new Uint32Array(count);
    for (let byte = 0; byte < bytes; byte++) {
      const plane = new Uint8Array(this.buffer, this.at, count);
      for (let i = 0; i < count; i++) found[i] |= plane[i] << (8 * byte);
      this.at += count;
    }
    let last = 0;
    for (let i = 0; i < count; i++) {
      last += (found[i] >>> 1) ^ -(found[i] & 1);
      found[i] = last;
      last = found[i];
    }
    return found;
  }
}

// A unit vector from its place on the octahedron.
function ofOctahedron(a, b) {
  const x = (2 * a) / 65535 - 1, y = (2 * b) / 65535 - 1, z = 1 - Math.abs(x) - Math.abs(y);
  const fold = Math.max(0, -z);
  return unit([x - Math.sign(x) * fold, y - Math.sign(y) * fold, z]);
}

export function unpackSurface(about, buffer) {
  const { vertices, low, high, grid, texel, scaleLow, scaleHigh } = about;
  const columns = new Columns(buffer);
  const read = () => columns.read(vertices, 2);
  const places = [read(), read(), read()], normals = [read(), read()], along = [read(), read()];
  const coords = [read(), read()];
  const scale = about.isScaled ? read() : null;
  const corners = columns.read(3 * about.triangles, 4);
  const vertex = (v) => {
    const normal = ofOctahedron(normals[0][v], normals[1][v]);
    const s = ofOctahedron(along[0][v], along[1][v]);
    const t = unit(cross(normal, s));
    const factor = scale ? Math.exp(scaleLow + ((scaleHigh - scaleLow) * scale[v]) / 65535) : 1;
    return {
      position: places.map((column, k) => low[k] + ((high[k] - low[k]) * column[v]) / 65535),
      normal, along: times(s, 1 / (texel * factor)), across: times(t, 1 / (texel * factor)),
      coord: coords.map((column, k) => (grid[k] * (column[v] + 0.5)) / 65536),
    };
  };
  return { vertices, triangles: about.triangles, corners, vertex };
}

// Textures of a surface, `width` vertices per row: see weights.frag.
export function surfaceTextures(surface, width) {
  const rows = Math.ceil(surface.vertices / width);
  const data = new Float32Array(12 * width * rows), normals = new Float32Array(4 * width * rows);
  for (let v = 0; v < surface.vertices; v++) {
    const { position, normal, along, across, coord } = surface.vertex(v);
    data.set([...position, coord[0], ...along, coord[1], ...across, 0], 12 * v);
    normals.set([...normal, 0], 4 * v);
  }
  setBounds(surface, data, normals);
  return { data, normals, rows };
}

// How far a vertex' normal may turn away from the viewer while a face round it is still seen.
function setBounds({ vertices, triangles, corners }, data, normals) {
  const least = new Float32Array(vertices).fill(1);
  const place = (v) => data.subarray(12 * v, 12 * v + 3);
  for (let f = 0; f < triangles; f++) {
    const face = corners.subarray(3 * f, 3 * f + 3);
    const [a, b, c] = [place(face[0]), place(face[1]), place(face[2])];
    const normal = cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
    const length = Math.hypot(...normal);
    for (const v of face) {
      const cosine = length > 0 ? dot(normal, normals.subarray(4 * v, 4 * v + 3)) / length : -1;
      if (cosine < least[v]) least[v] = cosine;
    }
  }
  for (let v = 0; v < vertices; v++) {
    data[12 * v + 11] = least[v] <= 0 ? -2 : -Math.sqrt(Math.max(0, 1 - least[v] * least[v])) - 1e-3;
  }
}

// Vertices such that every triangle has a last one of its own, which carries the triangle's number.
export function provokingVertices({ vertices, triangles, corners }) {
  const owner = new Int32Array(vertices).fill(-1);
  const sources = [], owners = [], elements = new Uint32Array(3 * triangles);
  for (let f = 0; f < triangles; f++) {
    const face = corners.subarray(3 * f, 3 * f + 3);
    let free = [0, 1, 2].find((k) => owner[face[k]] < 0);
    if (free === undefined) {
      free = 0;
      sources.push(face[0]);
      owners.push(f);
      elements[3 * f + 2] = vertices + sources.length - 1;
    } else {
      owner[face[free]] = f;
      elements[3 * f + 2] = face[free];
    }
    elements[3 * f] = face[(free + 1) % 3];
    elements[3 * f + 1] = face[(free + 2) % 3];
  }
  return { sources, owner: Int32Array.from([...owner, ...owners], (f) => Math.max(0, f)), elements };
}
