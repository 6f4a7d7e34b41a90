import test from 'node:test';
import assert from 'node:assert/strict';
import { VALUES, toHalf, toHalves } from '../../src/half_float.js';
import { background, partOf, patchFields, sumGroups, surfaceEmissions } from '../../src/relight.js';
import { autoExposure, curve, mapColour, mapLab, oklab, srgb } from '../../src/colour.js';

test('half floats round-trip and round to nearest', () => {
  for (let h = 0; h < 0x7c00; h++) assert.equal(toHalf(VALUES[h]), h);
  for (let i = 0; i < 2000; i++) {
    const x = Math.fround(2 ** (-20 + 0.017 * i));
    const h = toHalf(x);
    const off = Math.abs(VALUES[h] - x);
    assert.ok(off <= Math.abs(VALUES[h + 1] - x) && (h === 0 || off <= Math.abs(VALUES[h - 1] - x)), `${x}`);
  }
  assert.deepEqual([...toHalves([NaN, 1e9, -1e9])], [0, 0x7bff, 0xfbff]);
});

const scene = {
  groups: [
    { scales: { indirect: 2, direct: 1 }, background: [1, 0, 0] },
    { scales: { indirect: 4 }, background: [0, 2, 0] },
  ],
  surfaces: [{ emission: [1, 2, 3], group: 1 }, { emission: [0, 0, 0], group: null }],
  arrays: {
    indirect0: toHalves([1, 2, 3]),
    indirect1: toHalves([0.5, 0, 1]),
    direct0: toHalves([8, 0, 1]),
    zoneIndirect0: Float32Array.of(1, 2, 3),
    zoneDirect0: Float32Array.of(1, 1, 1),
    zoneIndirect1: Float32Array.of(10, 20, 30),
    zoneReflectance: Float32Array.of(0.5, 0.25, 0),
    zoneEmission: Float32Array.of(1, 2, 3),
    zoneError: Float32Array.of(0.1, 0.2, 0.3),
    zoneSurface: Uint16Array.of(0),
  },
};

test('group sums are linear in the factors', () => {
  assert.deepEqual([...sumGroups(scene, ['indirect'], [1, 1], 3)], [4, 4, 10]);
  assert.deepEqual([...sumGroups(scene, ['indirect'], [0, 3], 3)], [6, 0, 12]);
  assert.deepEqual([...sumGroups(scene, ['direct'], [2, 3], 3)], [16, 0, 2]);
  assert.deepEqual([...sumGroups(scene, ['indirect', 'direct'], [1, 1], 3)], [12, 4, 11]);
  assert.deepEqual([...sumGroups(scene, ['pane'], [1, 1], 3)], [0, 0, 0]);
  assert.deepEqual(surfaceEmissions(scene, [1, 2]), [[2, 4, 6], [0, 0, 0]]);
  assert.deepEqual(background(scene, [3, 0.5]), [3, 1, 0]);
});

test('patch fields obey B = E + ρ(H + H_dir)', () => {
  const p = patchFields(scene, 0, [2, 0.5]);
  assert.deepEqual(p.indirect, [7, 14, 21]);
  assert.deepEqual(p.direct, [2, 2, 2]);
  assert.deepEqual(p.irradiance, [9, 16, 23]);
  assert.deepEqual(p.radiosity, [0.5 + 4.5, 1 + 4, 1.5]);
  const [total, direct, indirect] = ['total', 'direct', 'indirect'].map((part) => partOf(p, 'irradiance', part));
  assert.deepEqual(total, direct.map((x, b) => x + indirect[b]));
  assert.deepEqual(partOf(p, 'radiosity', 'direct'), [1, 0.5, 0]);
  assert.deepEqual(partOf(p, 'error', 'direct'), p.error);
});

test('tone curve is that of zonal render', () => {
  assert.equal(curve(0.1), 0.1);
  assert.equal(curve(-1), 0);
  assert.equal(curve(Infinity), 1);
  assert.ok(Math.abs(curve(1) - 0.625) < 1e-12);
  let last = 0;
  for (let i = 0; i < 4000; i++) {
    const y = curve(i * 0.01);
    assert.ok(y >= last && y - last <= 0.0100001 && y <= 1);
    last = y;
  }
  assert.ok(Math.abs(srgb(0.5) - 0.7353569830524495) < 1e-9);
});

test('automatic exposure scales with the scene', () => {
  const grey = (s) => Float32Array.from({ length: 4000 }, (_, i) => s * (0.001 + (i >> 2) * 0.001));
  const ratio = autoExposure(grey(1)) / autoExposure(grey(100));
  assert.ok(Math.abs(ratio - 100) < 0.01);
  assert.equal(autoExposure(new Float32Array(8)), 1);
});

test('colour map is uniform in colour difference and monotonic in lightness', () => {
  const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const n = 200;
  const steps = Array.from({ length: n }, (_, i) => distance(mapLab(i / n), mapLab((i + 1) / n)));
  assert.ok(Math.max(...steps) / Math.min(...steps) < 1.1);
  for (let i = 0; i < n; i++) assert.ok(mapLab((i + 1) / n)[0] > mapLab(i / n)[0]);
});

test('colour map lies within the sRGB gamut', () => {
  for (let i = 0; i <= 100; i++) {
    const c = oklab(mapLab(i / 100));
    assert.ok(c.every((x) => x >= -1e-3 && x <= 1.001), `${i} %: ${c}`);
    assert.ok(mapColour(i / 100).every((x) => x >= 0 && x <= 1));
  }
});
