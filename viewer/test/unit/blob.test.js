import test from 'node:test';
import assert from 'node:assert/strict';
import { gzipSync } from 'node:zlib';
import { Damaged, fromBase64, inflate, parse } from '../../src/blob.js';

const position = new Float32Array(9);
const arrays = { position, uv: new Float32Array(6), surface: new Uint16Array(3), index: Uint32Array.of(0, 1, 2) };
const TYPES = new Map([[Float32Array, 'f32'], [Uint16Array, 'u16'], [Uint32Array, 'u32']]);

function blob(change = {}, head = {}) {
  const parts = [];
  const list = {};
  let offset = 0;
  for (const [name, a] of Object.entries({ ...arrays, ...change })) {
    list[name] = { type: TYPES.get(a.constructor), offset, length: a.length };
    const bytes = Buffer.from(a.buffer, a.byteOffset, a.byteLength);
    const padded = Buffer.concat([bytes, Buffer.alloc(-bytes.length & 7)]);
    parts.push(padded);
    offset += padded.length;
  }
  let text = JSON.stringify({ name: 'x', mesh: { vertices: 3 }, surfaces: [{}], ...head, arrays: { ...list, ...head.arrays } });
  text = text.padEnd(Math.ceil(text.length / 8) * 8);
  const size = Buffer.alloc(8);
  size.writeUInt32LE(text.length);
  return Buffer.concat([Buffer.from('ZONALVW1'), size, Buffer.from(text), ...parts]);
}
const buffer = (b) => b.buffer.slice(b.byteOffset, b.byteOffset + b.length);

test('a blob is read', async () => {
  const back = parse(await inflate([gzipSync(blob())]));
  assert.equal(back.name, 'x');
  assert.deepEqual([...back.arrays.index], [0, 1, 2]);
});

test('base64 is read in pieces', () => {
  const bytes = Buffer.from(Array.from({ length: 1000 }, (_, i) => (i * 7) & 255));
  const chunks = fromBase64(bytes.toString('base64'));
  assert.deepEqual(Buffer.concat(chunks), bytes);
  assert.throws(() => fromBase64('####'), Damaged);
});

test('damaged data are said to be', async () => {
  const packed = gzipSync(blob());
  await assert.rejects(inflate([packed.subarray(0, packed.length - 9)]), Damaged);
  const altered = Buffer.from(packed);
  altered[altered.length >> 1] ^= 8;
  await assert.rejects(inflate([altered]), Damaged);
  const wrong = [
    Buffer.alloc(4),
    Buffer.concat([Buffer.from('ZONALVW2'), blob().subarray(8)]),
    blob().subarray(0, 40),
    blob().subarray(0, blob().length - 8),
    blob({ index: Uint32Array.of(0, 1, 3) }),
    blob({ index: Uint32Array.of(0, 1) }),
    blob({ surface: Uint16Array.of(0, 0, 1) }),
    blob({ position: new Float32Array(6) }),
    blob({ irradiance0: new Uint16Array(3) }),
    blob({}, { arrays: { bad: { type: 'f64', offset: 0, length: 1 } } }),
    blob({}, { arrays: { bad: { type: 'f32', offset: 4, length: 1 } } }),
    blob({}, { arrays: { bad: { type: 'f32', offset: 0, length: 1e9 } } }),
  ];
  for (const b of wrong) assert.throws(() => parse(buffer(b)), Damaged);
});
