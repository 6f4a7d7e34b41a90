// Camera motion. A camera is { eye, forward, up, fov }: m, unit vectors, and the horizontal angle in degrees for pictures of 4:3 or wider.

import { add, cross, dot, frame, length, mix, rotate, scale, sub, unit } from './vector_math.js';

/** Largest |cosine| between the view direction and the vertical. */
const MAX_PITCH_COSINE = 0.995;

export const copy = (c) => ({ eye: [...c.eye], forward: [...c.forward], up: [...c.up], fov: c.fov });

/** The state of a camera of the scene. */
export const fromScene = (c) => ({ eye: [...c.origin], forward: unit(sub(c.target, c.origin)), up: unit(c.up), fov: c.fov });

/** A camera above a corner that shows the whole scene, for an aspect ratio (width over height). */
export function overview(bounds, aspect) {
  const centre = mix(bounds[0], bounds[1], 0.5);
  const forward = unit([-1, -1.4, -0.8]);
  const camera = { eye: centre, forward, up: [0, 0, 1], fov: 50 };
  const { tanX, tanY } = frame(camera, aspect);
  // The bounding sphere fills the narrower side of the picture.
  const radius = 0.5 * length(sub(bounds[1], bounds[0]));
  return { ...camera, eye: sub(centre, scale(forward, (0.95 * radius) / Math.sin(Math.atan(Math.min(tanX, tanY))))) };
}

/** Rotates the view by `yaw` to the left and `pitch` upwards, radians. */
export function look(c, yaw, pitch) {
  let forward = rotate(c.forward, c.up, yaw);
  const right = unit(cross(forward, c.up));
  const pitched = unit(rotate(forward, right, pitch));
  // Limit the pitch, but allow motion back from the limit.
  const cosine = Math.abs(dot(pitched, c.up));
  if (cosine < MAX_PITCH_COSINE || cosine < Math.abs(dot(forward, c.up))) forward = pitched;
  return { ...c, forward: unit(forward) };
}

/** Translates by metres ahead, to the right and up; ahead is horizontal for any pitch. */
export function walk(c, ahead, right, up) {
  const side = unit(cross(c.forward, c.up));
  const level = unit(cross(c.up, side));
  return { ...c, eye: add(c.eye, add(add(scale(level, ahead), scale(side, right)), scale(c.up, up))) };
}

/** Rotates about a point that keeps its position in the picture. */
export function orbit(c, pivot, yaw, pitch) {
  const right = unit(cross(c.forward, c.up));
  const cosine = dot(rotate(c.forward, right, pitch), c.up);
  const tilt = Math.abs(cosine) < MAX_PITCH_COSINE || Math.abs(cosine) < Math.abs(dot(c.forward, c.up)) ? pitch : 0;
  const both = (v) => rotate(rotate(v, right, tilt), c.up, yaw);
  return { ...c, eye: add(pivot, both(sub(c.eye, pivot))), forward: unit(both(c.forward)) };
}

/** Scales the distance to a point by a factor. */
export function zoom(c, pivot, factor) {
  return { ...c, eye: add(pivot, scale(sub(c.eye, pivot), factor)) };
}

/** Translates in the picture plane by fractions of its width and height at the distance of a point. */
export function pan(c, pivot, x, y, tanX, tanY) {
  const distance = Math.max(dot(sub(pivot, c.eye), c.forward), 1e-6);
  const right = unit(cross(c.forward, c.up));
  const up = cross(right, c.forward);
  const shift = add(scale(right, -2 * x * tanX * distance), scale(up, 2 * y * tanY * distance));
  return { camera: { ...c, eye: add(c.eye, shift) }, pivot: add(pivot, shift) };
}

/** Smoothstep interpolation of two cameras, t from 0 to 1. */
export function interpolate(a, b, t) {
  const s = t * t * (3 - 2 * t);
  return { eye: mix(a.eye, b.eye, s), forward: unit(mix(a.forward, b.forward, s)), up: unit(mix(a.up, b.up, s)), fov: a.fov + (b.fov - a.fov) * s };
}
