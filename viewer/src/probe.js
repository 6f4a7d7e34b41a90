// Probe: the surface point under a point of the picture and its fields.

import { VALUES } from './half_float.js';
import { patchFields } from './relight.js';

/**
 * The first triangle that a ray hits from its exchanging side, as { triangle, t, u, v, back }; backs of one-sided surfaces are hit too,
 * unless `hideBacks`.
 */
export function raycast(scene, eye, dir, hideBacks = false) {
  const { position: p, index, surface } = scene.arrays;
  const both = scene.surfaces.map((s) => s.both);
  const [dx, dy, dz] = dir;
  let best = null;
  let nearest = Infinity;
  for (let t = 0; t < index.length; t += 3) {
    const i = 3 * index[t];
    const j = 3 * index[t + 1];
    const k = 3 * index[t + 2];
    const e1x = p[j] - p[i], e1y = p[j + 1] - p[i + 1], e1z = p[j + 2] - p[i + 2];
    const e2x = p[k] - p[i], e2y = p[k + 1] - p[i + 1], e2z = p[k + 2] - p[i + 2];
    const qx = dy * e2z - dz * e2y, qy = dz * e2x - dx * e2z, qz = dx * e2y - dy * e2x;
    const det = e1x * qx + e1y * qy + e1z * qz;
    if (det === 0 || (det < 0 && (hideBacks || both[surface[index[t]]]))) continue;
    const sx = eye[0] - p[i], sy = eye[1] - p[i + 1], sz = eye[2] - p[i + 2];
    const u = (sx * qx + sy * qy + sz * qz) / det;
    if (u < 0 || u > 1) continue;
    const rx = sy * e1z - sz * e1y, ry = sz * e1x - sx * e1z, rz = sx * e1y - sy * e1x;
    const v = (dx * rx + dy * ry + dz * rz) / det;
    if (v < 0 || u + v > 1) continue;
    const distance = (e2x * rx + e2y * ry + e2z * rz) / det;
    if (distance > 0 && distance < nearest) {
      nearest = distance;
      best = { triangle: t / 3, t: distance, u, v, back: det < 0 };
    }
  }
  return best;
}

/** Names of the panes that a ray crosses before `end`, near to far. */
export function panesBefore(scene, eye, dir, end) {
  const { panePosition: position, paneIndex: index, paneOf } = scene.arrays;
  if (!index) return [];
  const crossed = new Map();
  const triangle = { arrays: { position, index: null, surface: paneOf }, surfaces: scene.panes.map(() => ({ both: false })) };
  for (let t = 0; t < index.length; t += 3) {
    triangle.arrays.index = index.subarray(t, t + 3);
    const hit = raycast(triangle, eye, dir);
    if (hit && hit.t < end) crossed.set(paneOf[index[t]], Math.min(hit.t, crossed.get(paneOf[index[t]]) ?? Infinity));
  }
  return [...crossed].sort((a, b) => a[1] - b[1]).map(([pane]) => scene.panes[pane].name);
}

/** The fields at the surface point that a ray hits, without the light of suns that are drawn; null without a hit. */
export function probe(scene, factors, eye, dir, hideBacks) {
  const hit = raycast(scene, eye, dir, hideBacks);
  if (!hit) return null;
  const { index, triangleZone, surface, error } = scene.arrays;
  const corners = [0, 1, 2].map((k) => index[3 * hit.triangle + k]);
  const weights = [1 - hit.u - hit.v, hit.u, hit.v];
  const at = (array, scale) => [0, 1, 2].map((b) => corners.reduce((s, c, k) => s + weights[k] * scale * VALUES[array[3 * c + b]], 0));
  const total = (stem) => scene.groups.reduce((sum, group, g) => {
    const values = scene.arrays[stem + g];
    const own = values ? at(values, factors[g] * group.scales[stem]) : [0, 0, 0];
    return sum.map((x, b) => x + own[b]);
  }, [0, 0, 0]);
  const zone = triangleZone[hit.triangle];
  const point = eye.map((x, k) => x + hit.t * dir[k]);
  return {
    point,
    position: point.map((x, k) => x + scene.origin[k]),
    distance: hit.t,
    back: hit.back,
    surface: scene.surfaces[surface[corners[0]]].name,
    zone,
    through: panesBefore(scene, eye, dir, hit.t),
    here: { indirect: total('indirect'), direct: total('direct'), error: at(error, scene.mesh.errorScale) },
    mean: patchFields(scene, zone, factors),
  };
}
