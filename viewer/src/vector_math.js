// Vectors as arrays of three numbers, matrices as sixteen numbers in column-major order.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const mix = (a, b, t) => [0, 1, 2].map((k) => a[k] + (b[k] - a[k]) * t);

/** Unit vector; zero for zero. */
export function unit(a) {
  const l = length(a);
  return l > 0 ? scale(a, 1 / l) : [0, 0, 0];
}

/** `v` rotated about the unit vector `axis` by an angle in radians (Rodrigues). */
export function rotate(v, axis, angle) {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

/** The product of two matrices. */
export function multiply(a, b) {
  const out = new Array(16).fill(0);
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    }
  }
  return out;
}

/** Least aspect ratio for which the camera angle is horizontal; narrower pictures keep the vertical angle of this one. */
export const MIN_ASPECT = 4 / 3;

/**
 * The view frustum of a camera for an aspect ratio (width over height): unit vectors forward, right and up, tangents of half the
 * horizontal and vertical angles. Equal to crates/render/src/camera.rs for aspect ratios of 4:3 and above.
 */
export function frame(camera, aspect) {
  const forward = unit(camera.forward);
  const right = unit(cross(forward, camera.up));
  const up = cross(right, forward);
  const tanHorizontal = Math.tan((camera.fov * Math.PI) / 360);
  const tanY = tanHorizontal / Math.max(aspect, MIN_ASPECT);
  return { forward, right, up, tanX: tanY * aspect, tanY };
}

/** The matrix from scene to clip space. */
export function viewProjection(eye, f, near, far) {
  const { right: r, up: u, forward: w } = f;
  const view = [r[0], u[0], -w[0], 0, r[1], u[1], -w[1], 0, r[2], u[2], -w[2], 0, -dot(r, eye), -dot(u, eye), dot(w, eye), 1];
  const projection = [1 / f.tanX, 0, 0, 0, 0, 1 / f.tanY, 0, 0, 0, 0, -(far + near) / (far - near), -1, 0, 0, (-2 * far * near) / (far - near), 0];
  return multiply(projection, view);
}

/** Unit direction through a point of the picture, both coordinates from 0 to 1 with y down. */
export function direction(f, x, y) {
  return unit(add(f.forward, add(scale(f.right, (2 * x - 1) * f.tanX), scale(f.up, (1 - 2 * y) * f.tanY))));
}

/** Picture coordinates of a point, 0 to 1 with y down; null behind the camera. */
export function project(f, eye, point) {
  const d = sub(point, eye);
  const z = dot(d, f.forward);
  if (z <= 0) return null;
  return [0.5 + (0.5 * dot(d, f.right)) / (z * f.tanX), 0.5 - (0.5 * dot(d, f.up)) / (z * f.tanY)];
}
