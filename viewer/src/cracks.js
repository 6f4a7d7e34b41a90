// Cracks at T-junctions: where a corner of one patch lies inside an edge of another, rounding leaves gaps that show single pixels of the
// background. Open edges that another edge overlaps in part are drawn as lines too, slightly behind the surfaces.

import { dot, length, mix, sub } from './vector_math.js';

/**
 * Welds vertices: one number and the same coordinates for all vertices at one position, to 2⁻¹⁷ of the scene's size. Patches compute
 * the points of a common edge separately, so that the last bit may differ.
 */
export function weld(position) {
  const count = position.length / 3;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < position.length; i++) {
    low[i % 3] = Math.min(low[i % 3], position[i]);
    high[i % 3] = Math.max(high[i % 3], position[i]);
  }
  const fine = 2 ** 17 / Math.max(...high.map((h, k) => h - low[k]), 1e-30);
  const step = (i, k) => Math.min(Math.round((position[3 * i + k] - low[k]) * fine), 2 ** 17 - 1);
  const first = new Map();
  const ids = new Uint32Array(count);
  for (let i = 0; i < count; i++) {
    const key = (step(i, 0) * 2 ** 17 + step(i, 1)) * 2 ** 17 + step(i, 2);
    const known = first.get(key);
    if (known === undefined) first.set(key, i);
    else position.copyWithin(3 * i, 3 * known, 3 * known + 3);
    ids[i] = known ?? i;
  }
  return ids;
}

/** The edges of triangles that no other triangle shares, as [vertex, vertex, position in the order]. */
function openEdges({ order }, ids) {
  const seen = new Map();
  const key = (a, b) => Math.min(ids[a], ids[b]) * 2 ** 26 + Math.max(ids[a], ids[b]);
  const each = (does) => {
    for (let t = 0; t < order.length; t += 3) {
      for (let k = 0; k < 3; k++) does(order[t + k], order[t + ((k + 1) % 3)], t);
    }
  };
  each((a, b) => seen.set(key(a, b), (seen.get(key(a, b)) ?? 0) + 1));
  const edges = [];
  each((a, b, t) => seen.get(key(a, b)) === 1 && edges.push([a, b, t]));
  return edges;
}

/** Returns a function that tests whether another open edge passes a point of an edge. */
function edgeOverlap(position, edges, ids) {
  const at = (v) => [position[3 * v], position[3 * v + 1], position[3 * v + 2]];
  const reach = position.reduce((m, x) => Math.max(m, Math.abs(x)), 0);
  const [cell, near] = [reach / 128, 4e-6 * reach];
  const place = (x) => Math.floor(x / cell) + 256;
  const key = (x, y, z) => (x * 512 + y) * 512 + z;
  const cells = new Map();
  const put = (k, e) => {
    if (!cells.has(k)) cells.set(k, [e]);
    else if (cells.get(k).at(-1) !== e) cells.get(k).push(e);
  };
  edges.forEach(([a, b], e) => {
    const [p, q] = [at(a), at(b)];
    const pieces = Math.ceil(length(sub(q, p)) / cell);
    for (let i = 0; i < pieces; i++) {
      const [from, to] = [mix(p, q, i / pieces), mix(p, q, (i + 1) / pieces)];
      const [low, high] = [0, 1, 2].map((c) => [Math.min(from[c], to[c]) - near, Math.max(from[c], to[c]) + near].map(place)).reduce(([l, h], [x, y]) => [[...l, x], [...h, y]], [[], []]);
      for (let x = low[0]; x <= high[0]; x++) {
        for (let y = low[1]; y <= high[1]; y++) {
          for (let z = low[2]; z <= high[2]; z++) put(key(x, y, z), e);
        }
      }
    }
  });
  return (self, share) => {
    const [a, b] = edges[self];
    const m = mix(at(a), at(b), share);
    return cells.get(key(...m.map(place)))?.some((e) => {
      const [c, d] = edges[e];
      if (e === self || (ids[c] === ids[a] && ids[d] === ids[b])) return false;
      const p = at(c);
      const axis = sub(at(d), p);
      const t = dot(sub(m, p), axis) / dot(axis, axis);
      return t > 0 && t < 1 && length(sub(m, mix(p, at(d), t))) < near;
    }) ?? false;
  };
}

/** The lines to draw, as pairs of vertices, in runs like those of `groupByTexture`; `ids` comes from `weld`. */
export function crackLines(triangles, ids, position) {
  const edges = openEdges(triangles, ids);
  const overlaps = edgeOverlap(position, edges, ids);
  const lines = [];
  const out = [];
  let run = 0;
  edges.forEach(([a, b, t], e) => {
    while (t >= triangles.runs[run].first + triangles.runs[run].count) run++;
    if (![0.5, 0.25, 0.75].some((share) => overlaps(e, share))) return;
    out[run] ??= { ...triangles.runs[run], first: lines.length, count: 0 };
    lines.push(a, b);
    out[run].count += 2;
  });
  return { lines: Uint32Array.from(lines), runs: out.filter(Boolean) };
}
