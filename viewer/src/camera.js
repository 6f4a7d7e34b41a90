// The camera as a thing that moves: { eye, forward, up, fov } with unit vectors and degrees across a 4:3 picture or wider.

import { add, cross, dot, frame, length, mix, scale, sub, turn, unit } from './maths.js';

/** How near to straight up or down one may look, as the cosine. */
const STEEP = 0.995;

export const copy = (c) => ({ eye: [...c.eye], forward: [...c.forward], up: [...c.up], fov: c.fov });

/** A camera of the scene. */
export const named = (c) => ({ eye: [...c.origin], forward: unit(sub(c.target, c.origin)), up: unit(c.up), fov: c.fov });

/** The whole of the scene from a corner above, for a picture with an aspect (width over height). */
export function overview(bounds, aspect) {
  const centre = mix(bounds[0], bounds[1], 0.5);
  const forward = unit([-1, -1.4, -0.8]);
  const camera = { eye: centre, forward, up: [0, 0, 1], fov: 50 };
  const { tanX, tanY } = frame(camera, aspect);
  // The ball around it fills the narrower side, but for its edge.
  const reach = 0.5 * length(sub(bounds[1], bounds[0]));
  return { ...camera, eye: sub(centre, scale(forward, (0.95 * reach) / Math.sin(Math.atan(Math.min(tanX, tanY))))) };
}

/** Looks around: `across` to the left, `upward` up, radians. */
export function look(c, across, upward) {
  let forward = turn(c.forward, c.up, across);
  const right = unit(cross(forward, c.up));
  const raised = unit(turn(forward, right, upward));
  // Not over the head, but back from there.
  const steep = Math.abs(dot(raised, c.up));
  if (steep < STEEP || steep < Math.abs(dot(forward, c.up))) forward = raised;
  return { ...c, forward: unit(forward) };
}

/** Goes: metres ahead, to the right and up; ahead along the floor, whatever one looks at. */
export function walk(c, ahead, right, up) {
  const side = unit(cross(c.forward, c.up));
  const level = unit(cross(c.up, side));
  return { ...c, eye: add(c.eye, add(add(scale(level, ahead), scale(side, right)), scale(c.up, up))) };
}

/** Goes about a point that stays where it is in the picture. */
export function orbit(c, pivot, across, upward) {
  const right = unit(cross(c.forward, c.up));
  const steep = dot(turn(c.forward, right, upward), c.up);
  const tilt = Math.abs(steep) < STEEP || Math.abs(steep) < Math.abs(dot(c.forward, c.up)) ? upward : 0;
  const both = (v) => turn(turn(v, right, tilt), c.up, across);
  return { ...c, eye: add(pivot, both(sub(c.eye, pivot))), forward: unit(both(c.forward)) };
}

/** Comes nearer to a point by a factor below one, or goes away. */
export function zoom(c, pivot, factor) {
  return { ...c, eye: add(pivot, scale(sub(c.eye, pivot), factor)) };
}

/** Shifts the picture: shares of its width and height at the distance of a point. */
export function pan(c, pivot, x, y, tanX, tanY) {
  const far = Math.max(dot(sub(pivot, c.eye), c.forward), 1e-6);
  const right = unit(cross(c.forward, c.up));
  const up = cross(right, c.forward);
  const shift = add(scale(right, -2 * x * tanX * far), scale(up, 2 * y * tanY * far));
  return { camera: { ...c, eye: add(c.eye, shift) }, pivot: add(pivot, shift) };
}

/** Part of the way from one camera to another, 0 to 1, eased. */
export function between(a, b, t) {
  const s = t * t * (3 - 2 * t);
  return { eye: mix(a.eye, b.eye, s), forward: unit(mix(a.forward, b.forward, s)), up: unit(mix(a.up, b.up, s)), fov: a.fov + (b.fov - a.fov) * s };
}
