import test from 'node:test';
import assert from 'node:assert/strict';
import * as cameras from '../../src/camera.js';
import { cross, direction, dot, frame, length, project, sub, viewProjection } from '../../src/vector_math.js';
import { raycast, probe } from '../../src/probe.js';
import { count, fromSlider, number, ticks, toSlider } from '../../src/format.js';
import * as urlState from '../../src/url_state.js';
import { groupByTexture, halveResolution } from '../../src/scene.js';
import { crackLines, weld } from '../../src/cracks.js';
import { toHalves } from '../../src/half_float.js';

const close = (a, b, e = 1e-9) => a.forEach((x, k) => assert.ok(Math.abs(x - b[k]) <= e, `${a} ${b}`));
const camera = { eye: [1, 2, 3], forward: [0, 1, 0], up: [0, 0, 1], fov: 90 };

test('field of view is horizontal from 4:3 on and vertical in narrower windows', () => {
  const wide = frame(camera, 2);
  close(direction(wide, 1, 0.5), [Math.SQRT1_2, Math.SQRT1_2, 0]);
  close([wide.tanX, wide.tanY], [1, 0.5]);
  const tall = frame(camera, 0.5);
  close([tall.tanX, tall.tanY], [0.375, 0.75]);
});

test('projection, its inverse and the matrix agree', () => {
  const f = frame({ ...camera, forward: [0.6, 0.64, -0.48] }, 1.5);
  const m = viewProjection(camera.eye, f, 0.1, 100);
  for (const [x, y] of [[0.1, 0.2], [0.5, 0.5], [0.9, 0.7]]) {
    const d = direction(f, x, y);
    const p = camera.eye.map((e, k) => e + 7 * d[k]);
    close(project(f, camera.eye, p), [x, y]);
    const clip = [0, 1, 2, 3].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
    close([clip[0] / clip[3], clip[1] / clip[3]], [2 * x - 1, 1 - 2 * y]);
    assert.ok(Math.abs(clip[2] / clip[3]) < 1);
  }
  assert.equal(project(f, camera.eye, sub(camera.eye, f.forward)), null);
});

test('pitch is limited', () => {
  let c = camera;
  for (let i = 0; i < 50; i++) c = cameras.look(c, 0.1, 0.3);
  assert.ok(Math.abs(length(c.forward) - 1) < 1e-9 && dot(c.forward, c.up) < 0.9999);
  for (let i = 0; i < 20; i++) c = cameras.look(c, 0, -0.3);
  assert.ok(dot(c.forward, c.up) < 0, 'pitch returns from the limit');
});

test('walking is horizontal and orbiting keeps the distance', () => {
  const down = cameras.look(camera, 0, -0.7);
  close(cameras.walk(down, 2, 0, 0).eye, [1, 4, 3]);
  close(cameras.walk(down, 0, 1, 0).eye, [2, 2, 3]);
  const pivot = [1, 6, 2];
  let c = camera;
  for (let i = 0; i < 9; i++) c = cameras.orbit(c, pivot, 0.4, 0.1);
  assert.ok(Math.abs(length(sub(c.eye, pivot)) - length(sub(camera.eye, pivot))) < 1e-9);
  assert.ok(Math.abs(dot(cross(c.forward, c.up), [0, 0, 1])) < 1e-9);
});

test('overview contains the scene for any aspect ratio', () => {
  const bounds = [[-3, -5, -1], [3, 5, 5]];
  for (const aspect of [0.4, 1, 2.5]) {
    const c = cameras.overview(bounds, aspect);
    for (let k = 0; k < 8; k++) {
      const corner = [0, 1, 2].map((i) => bounds[(k >> i) & 1][i]);
      const at = project(frame(c, aspect), c.eye, corner);
      assert.ok(at.every((x) => x > 0 && x < 1), `${aspect} ${at}`);
    }
  }
});

// A floor of two surfaces: the left one-sided, the right seen from both sides.
const floor = {
  origin: [10, 0, 0],
  groups: [{ scales: { indirect: 1, direct: 1 }, background: [0, 0, 0] }],
  surfaces: [
    { name: 'left', both: false, emission: [0, 0, 0], group: null, reflectance: [1, 1, 1] },
    { name: 'right', both: true, emission: [0, 0, 0], group: null, reflectance: [1, 1, 1] },
  ],
  panes: [{ name: 'glass' }],
  mesh: { errorScale: 2 },
  arrays: {
    position: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 0),
    surface: Uint16Array.of(0, 0, 0, 1, 1, 1),
    index: Uint32Array.of(0, 1, 2, 3, 4, 5),
    triangleZone: Uint32Array.of(0, 1),
    error: toHalves(new Array(18).fill(0.5)),
    indirect0: toHalves([0, 0, 0, 4, 4, 4, 8, 8, 8, 1, 1, 1, 1, 1, 1, 1, 1, 1]),
    direct0: toHalves([2, 2, 2, 2, 2, 2, 2, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
    zoneIndirect0: Float32Array.of(1, 1, 1, 2, 2, 2),
    zoneReflectance: new Float32Array(6).fill(0.5),
    zoneEmission: new Float32Array(6),
    zoneError: new Float32Array(6).fill(0.25),
    zoneSurface: Uint16Array.of(0, 1),
    panePosition: Float32Array.of(-5, -5, 1, 5, -5, 1, 0, 5, 1),
    paneIndex: Uint32Array.of(0, 1, 2),
    paneOf: Uint16Array.of(0, 0, 0),
  },
};

test('rays hit fronts, and backs unless they are hidden', () => {
  close([raycast(floor, [0.25, 0.25, 2], [0, 0, -1]).t], [2]);
  assert.equal(raycast(floor, [0.25, 0.25, -1], [0, 0, 1]).back, true);
  assert.equal(raycast(floor, [0.25, 0.25, -1], [0, 0, 1], true), null);
  assert.equal(raycast(floor, [2.25, 0.25, -1], [0, 0, 1]), null);
  assert.equal(raycast(floor, [0.25, 0.25, 2], [0, 0, 1]), null);
  assert.equal(raycast(floor, [0.9, 0.9, 2], [0, 0, -1]), null);
});

test('probe interpolates and names surface, zone and panes', () => {
  const found = probe(floor, [3], [0.25, 0.5, 2], [0, 0, -1], false);
  close(found.here.indirect, [15, 15, 15]);
  close(found.here.direct, [6, 6, 6]);
  close(found.here.error, [1, 1, 1]);
  close(found.position, [10.25, 0.5, 0]);
  close(found.mean.irradiance, [3, 3, 3]);
  assert.deepEqual([found.surface, found.zone, found.through], ['left', 0, ['glass']]);
});

test('triangles are grouped by texture without loss', () => {
  const two = { surfaces: [{ texture: 1, emissionTexture: null }, { texture: null, emissionTexture: null }], arrays: { index: Uint32Array.of(0, 1, 2, 3, 4, 5, 0, 2, 1), surface: floor.arrays.surface } };
  const { order, runs } = groupByTexture(two);
  assert.deepEqual([...order], [0, 1, 2, 0, 2, 1, 3, 4, 5]);
  assert.deepEqual(runs.map((r) => [r.texture, r.first, r.count]), [[1, 0, 6], [null, 6, 3]]);
});

test('partly overlapping edges are cracks, borders are not', () => {
  // A square of two triangles with vertices of their own, and a third that meets half of one side.
  const position = Float32Array.of(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1e-7, 1, 1, 0, 0, 1, 0, 1, 0, 0, 2, 0, 0, 1, 0.5, 0);
  const ids = weld(position);
  assert.deepEqual([...ids], [0, 1, 2, 0, 2, 5, 1, 7, 8]);
  assert.equal(position[11], 0);
  const { lines, runs } = crackLines({ order: Uint32Array.of(0, 1, 2, 3, 4, 5, 6, 7, 8), runs: [{ first: 0, count: 9 }] }, ids, position);
  assert.deepEqual([...lines], [1, 2, 8, 6]);
  assert.deepEqual(runs, [{ first: 0, count: 4 }]);
});

test('halving the resolution keeps the mean', () => {
  const values = Float32Array.from({ length: 3 * 4 * 2 * 2 }, (_, i) => i);
  const small = halveResolution(values, [2, 2, 4]);
  assert.deepEqual(small.dims, [1, 1, 2]);
  const mean = (v) => v.reduce((s, x) => s + x, 0) / v.length;
  assert.ok(Math.abs(mean(small.values) - mean(values)) < 1e-5);
});

test('numbers, sliders and ticks are formatted', () => {
  assert.deepEqual([0, 1234.5678, 12.3456, 0.00012345, 1e7, NaN].map((x) => number(x)), ['0', '1235', '12.35', '1.234e-4', '1.000e7', '–']);
  assert.equal(count(1234567), '1\u202f234\u202f567');
  assert.equal(fromSlider(-8), 0);
  for (const f of [0.01, 0.5, 1, 20]) assert.ok(Math.abs(fromSlider(toSlider(f)) - f) < 1e-12);
  assert.deepEqual(ticks(0, 10, false), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks(1, 100, true).map((x) => Math.round(x)), [1, 3, 10, 30, 100]);
  assert.deepEqual(ticks(3, 3, true), [3]);
});

const state = { camera, mode: 'orbit', stops: 1.5, density: 0, show: 'error', part: 'direct', band: 'red', log: false, range: [1, 5], factors: [0.25, 1] };
const groups = [{ name: 'sun & moon' }, { name: 'sky' }];

test('URL state round trip', () => {
  const { at, ...rest } = urlState.read(urlState.write(state, groups), groups);
  assert.equal(at, undefined);
  close(rest.camera.eye, camera.eye);
  assert.deepEqual({ ...rest, camera }, state);
});

test('invalid URL state is ignored', () => {
  assert.deepEqual(urlState.read('#eye=1,2&to=0,1,0&mode=fly&ev=nan&density=-1&range=5,1&light.sky=x', groups), {});
  assert.deepEqual(urlState.read('#eye=1,2,3&to=0,0,1', groups), {}, 'up along the view');
  assert.deepEqual(urlState.read('', groups), {});
});
