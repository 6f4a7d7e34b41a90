import test from 'node:test';
import assert from 'node:assert/strict';
import { gzipSync } from 'node:zlib';
import { UnusableError, fromBase64, inflate, parse } from '../../src/data_package.js';

const position = new Float32Array(9);
const arrays = { position, uv: new Float32Array(6), surface: new Uint16Array(3), index: Uint32Array.of(0, 1, 2) };
const TYPES = new Map([[Float32Array, 'f32'], [Uint16Array, 'u16'], [Uint32Array, 'u32']]);

function pack(change = {}, head = {}) {
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

test('package round trip', async () => {
  const back = parse(await inflate([gzipSync(pack())]));
  assert.equal(back.name, 'x');
  assert.deepEqual([...back.arrays.index], [0, 1, 2]);
});

test('base64 is decoded in chunks', () => {
  const bytes = Buffer.from(Array.from({ length: 1000 }, (_, i) => (i * 7) & 255));
  const chunks = fromBase64(bytes.toString('base64'));
  assert.deepEqual(Buffer.concat(chunks), bytes);
  assert.throws(() => fromBase64('####'), UnusableError);
});

test('damaged data are rejected', async () => {
  const packed = gzipSync(pack());
  await assert.rejects(inflate([packed.subarray(0, packed.length - 9)]), UnusableError);
  const altered = Buffer.from(packed);
  altered[altered.length >> 1] ^= 8;
  await assert.rejects(inflate([altered]), UnusableError);
  const wrong = [
    Buffer.alloc(4),
    Buffer.concat([Buffer.from('ZONALVW2'), pack().subarray(8)]),
    pack().subarray(0, 40),
    pack().subarray(0, pack().length - 8),
    pack({ index: Uint32Array.of(0, 1, 3) }),
    pack({ index: Uint32Array.of(0, 1) }),
    pack({ surface: Uint16Array.of(0, 0, 1) }),
    pack({ position: new Float32Array(6) }),
    pack({ indirect0: new Uint16Array(3) }),
    pack({ direct0: new Uint16Array(3) }),
    pack({}, { arrays: { bad: { type: 'f64', offset: 0, length: 1 } } }),
    pack({}, { arrays: { bad: { type: 'f32', offset: 4, length: 1 } } }),
    pack({}, { arrays: { bad: { type: 'f32', offset: 0, length: 1e9 } } }),
  ];
  for (const b of wrong) assert.throws(() => parse(buffer(b)), UnusableError);
});
