import assert from 'node:assert/strict';
import { test } from 'node:test';
import { describe, follow, isSameScene, waitForData } from '../../src/live.js';

/** Answers of the server one after the other; the last one stays, and null is no answer. */
function server(answers) {
  let at = 0;
  globalThis.fetch = async () => {
    const a = answers[Math.min(at++, answers.length - 1)];
    if (a === null) throw new Error('no answer');
    return { ok: true, json: async () => a };
  };
  globalThis.setTimeout = (done) => queueMicrotask(done);
}
const at = (version, more = {}) => ({ live: true, version, stage: 'gather', fraction: 0.25, quality: 'draft', done: false, error: null, ...more });

test('the first data are waited for', async () => {
  server([at(0), at(0, { fraction: 0.5 }), at(1)]);
  const seen = [];
  const p = await waitForData((p) => seen.push(describe(p)));
  assert.equal(p.version, 1);
  assert.deepEqual(seen, ['Solving (draft): gather 25 %', 'Solving (draft): gather 50 %']);
});

test('each version is loaded once, in order, until the server ends', async () => {
  server([at(1), at(2), at(2, { done: true }), at(2, { done: true, error: 'hall.toml:3: unknown key' }), at(4), null]);
  const [lines, loads] = [[], []];
  await follow(1, (line) => lines.push(line), async () => loads.push(lines.length));
  assert.deepEqual(loads, [2, 5]);
  assert.deepEqual(lines.slice(2), ['', 'Not solved: hall.toml:3: unknown key', 'Solving (draft): gather 25 %', 'The server has ended; the page shows its last data.']);
});

test('a changed scene is not the same', () => {
  const data = { name: 'a', groups: [{ name: 'sun' }], cameras: [], origin: [0, 0, 0], bounds: [[0, 0, 0], [1, 1, 1]] };
  assert.ok(isSameScene(data, structuredClone(data)));
  assert.ok(!isSameScene(data, { ...data, groups: [{ name: 'sky' }] }));
  assert.ok(!isSameScene(data, { ...data, volume: {} }));
});
