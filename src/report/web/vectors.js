// Vectors of three numbers, and directions by azimuth and elevation.

export const add = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const times = (a, scale) => [a[0] * scale, a[1] * scale, a[2] * scale];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const unit = (a) => times(a, 1 / Math.hypot(...a));

export const RADIANS = Math.PI / 180;

// The world direction at angles in degrees: azimuth turns counter-clockwise seen from above, elevation is from the
// horizontal. `zero` is the horizontal direction of azimuth 0.
export function direction({ up, zero }, { azimuth, elevation }) {
  const left = cross(up, zero);
  const level = add(times(zero, Math.cos(azimuth * RADIANS)), left, Math.sin(azimuth * RADIANS));
  return unit(add(times(level, Math.cos(elevation * RADIANS)), up, Math.sin(elevation * RADIANS)));
}

// Angles after a drag, the elevation kept off the poles.
export function turned({ azimuth, elevation }, across, upwards) {
  const wrapped = ((((azimuth + across + 180) % 360) + 360) % 360) - 180;
  return { azimuth: wrapped, elevation: Math.max(-89, Math.min(89, elevation + upwards)) };
}
