import test from 'node:test';
import assert from 'node:assert/strict';
import { cameraFile, cameraOptions } from '../../src/camera_file.js';

const camera = { origin: [1.25, -2, 1e-7], target: [0, -0, 12345.678901234], up: [0, 0, 1], fov: 60.0000001 };

test('camera file has the keys of a scene', () => {
  const text = cameraFile(camera);
  assert.match(text, /^\[\[camera\]\]\nname = "view"$/m);
  assert.match(text, /^origin = \[1\.25, -2, 1e-7\]$/m);
  assert.match(text, /^target = \[0, 0, 12345\.6789\]$/m);
  assert.match(text, /^up = \[0, 0, 1\]$/m);
  assert.match(text, /^fov = 60\.0000001$/m);
});

test('options leave out the upward direction unless it is turned', () => {
  assert.equal(cameraOptions(camera), '--from 1.25,-2,1e-7 --look-at 0,0,12345.6789 --fov 60.0000001');
  assert.match(cameraOptions({ ...camera, up: [0, 0.6, 0.8] }), / --up 0,0\.6,0\.8$/);
});
