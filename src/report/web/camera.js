// The camera of `mesotex render --camera-path`: fitted to the mesh's bounding sphere, turned and zoomed.

import { add, cross, direction, RADIANS, times, unit } from "./vectors.js";

const MARGIN = 1.05;

// Position and axes of a camera at angles, so far off that the sphere fills the picture at zoom 1.
export function fittedCamera({ centre, radius, fov, compass }, angles, zoom, aspect) {
  const half = Math.tan((0.5 * fov * RADIANS));
  const slope = (half * Math.min(1, aspect)) / MARGIN;
  const distance = (radius * Math.hypot(1, slope)) / slope;
  const towards = direction(compass, angles);
  const eye = add(centre, towards, distance);
  const forward = times(towards, -1);
  const right = unit(cross(forward, compass.up));
  const reach = MARGIN * radius;
  return {
    eye, forward, right, up: cross(right, forward), half: half / zoom, aspect,
    near: Math.max(distance - reach, 1e-3 * distance), far: distance + reach,
  };
}

// Column-major, for WebGL's clip space.
export function clipFromWorld({ eye, forward, right, up, half, aspect, near, far }) {
  const rows = [times(right, 1 / (half * aspect)), times(up, 1 / half),
    times(forward, (far + near) / (far - near)), forward];
  const shift = [0, 0, (-2 * far * near) / (far - near), 0];
  const matrix = new Float32Array(16);
  rows.forEach((row, i) => {
    row.forEach((value, k) => {
      matrix[4 * k + i] = value;
    });
    matrix[12 + i] = shift[i] - (row[0] * eye[0] + row[1] * eye[1] + row[2] * eye[2]);
  });
  return matrix;
}

// The ray through the pixel (x, y) from below is corner + x · right + y · up.
export function pixelRays({ forward, right, up, half, aspect }, width, height) {
  const across = (2 * half * aspect) / width, upwards = (2 * half) / height;
  const corner = add(add(forward, right, -half * aspect), up, -half);
  return { corner, right: times(right, across), up: times(up, upwards) };
}
