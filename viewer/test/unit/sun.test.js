import test from 'node:test';
import assert from 'node:assert/strict';
import { fitMap, mapClip, mapSpace } from '../../src/sun_maps.js';
import { sunCode } from '../../src/sun_shader.js';
import { dot, unit } from '../../src/vector_math.js';

const bounds = [[-30, -8, -9], [30, 8, 9]];
const corners = Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((k) => bounds[(i >> k) & 1][k]));
const times = (m, p) => [0, 1, 2].map((r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);

for (const towards of [[0.3, -0.9, 0.5], [0, 0, 1], [0, 0, -1], [1, 0, 0]]) {
  test(`map of a sun towards ${towards} holds the scene, with depth along the light`, () => {
    const map = fitMap(towards, bounds);
    for (const [a, b] of [['right', 'up'], ['up', 'towards'], ['towards', 'right']]) assert.ok(Math.abs(dot(map[a], map[b])) < 1e-12);
    for (const p of corners) {
      const q = times(mapSpace(map), p);
      const clip = times(mapClip(map), p);
      q.forEach((x, k) => {
        assert.ok(x > 0 && x < 2 * map.half[k], `${q}`);
        // Texture coordinates and depth are those of the rasteriser.
        assert.ok(Math.abs(0.5 + 0.5 * clip[k] - (0.5 * x) / map.half[k]) < 1e-12);
      });
      // One metre towards the sun is one metre nearer to its side of the map.
      const nearer = times(mapSpace(map), p.map((x, k) => x + unit(towards)[k]));
      assert.ok(Math.abs(q[2] - nearer[2] - 1) < 1e-9 && Math.abs(q[0] - nearer[0]) < 1e-9);
    }
  });
}

test('map of a long building is turned along it', () => {
  const { half } = fitMap([0, 0, 1], [[-30, -30, 0], [30, 30, 0]]);
  assert.ok(half[0] * half[1] < 1.06 * 900);
  const long = fitMap([0.6, 0.6, 0.5], bounds);
  const box = [long.right, long.up].map((axis) => Math.max(...corners.map((c) => Math.abs(dot(c, axis)))));
  assert.ok(long.half[0] <= 1.021 * box[0] && long.half[1] <= 1.021 * box[1]);
});

test('shader code declares a depth for each sun', () => {
  assert.ok(!sunCode(0).includes('uniform'));
  assert.equal(sunCode(3).match(/uniform highp sampler3D sunDepth\d/g).length, 3);
});
