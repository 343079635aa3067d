// Which sampled directions may be near a wanted one, cell by cell of the hemisphere: a superset of those that the rule
// `continuous` reaches from anywhere in the cell, so that the shader looks at a few only.

import { dot } from "./vectors.js";

const SIDE = 64;
const COUNTED = 5;
const REACH = 1.05;

const angle = (a, b) => Math.acos(Math.min(1, Math.max(-1, dot(a, b))));

// A point of the equal-area disc as a direction; beyond the disc the nearest of the horizon.
function onHemisphere(x, y) {
  const radius = Math.hypot(x, y);
  if (radius > 1) return [x / radius, y / radius, 0];
  const z = 1 - radius * radius, scale = Math.sqrt(1 + z);
  return [x * scale, y * scale, z];
}

function candidatesOf(directions, column, row) {
  const corner = (i, j) => onHemisphere((2 * (column + i)) / SIDE - 1, (2 * (row + j)) / SIDE - 1);
  const middle = corner(0.5, 0.5);
  const around = [0, 0.25, 0.5, 0.75, 1].flatMap((i) => [0, 0.25, 0.5, 0.75, 1].map((j) => corner(i, j)));
  const extent = 1.1 * Math.max(...around.map((point) => angle(middle, point)));
  const distances = directions.map((other) => angle(middle, other));
  if (directions.length < COUNTED) return directions.map((_, index) => index);
  const counted = [...distances].sort((a, b) => a - b)[COUNTED - 1];
  const reach = REACH * (counted + extent) + extent;
  return directions.flatMap((_, index) => (distances[index] <= reach ? [index] : []));
}

// Rows of cells: directions with their indices, then an index below 0 where there is room.
export function candidateTable(directions) {
  const lists = [];
  for (let row = 0; row < SIDE; row++) {
    for (let column = 0; column < SIDE; column++) lists.push(candidatesOf(directions, column, row));
  }
  const width = Math.max(...lists.map((list) => list.length));
  const table = new Float32Array(4 * width * lists.length).fill(-1);
  lists.forEach((list, row) => {
    list.forEach((index, place) => {
      table.set([...directions[index], index], 4 * (row * width + place));
    });
  });
  return { table, width, rows: lists.length };
}
