// The blob of a baked solution: see crates/zonal/src/viewer/pack.rs.

const MAGIC = 'ZONALVW1';
const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f16: Uint16Array };

/** What is wrong with the data, in words for the reader. */
export class Damaged extends Error {}

/** Inflates gzip; its check sum guards all that follows. */
export async function inflate(chunks) {
  if (typeof DecompressionStream === 'undefined') {
    throw new Damaged('This browser cannot unpack the data (no DecompressionStream). A version of 2023 or later can.');
  }
  try {
    const stream = new Blob(chunks).stream().pipeThrough(new DecompressionStream('gzip'));
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new Damaged('The data are incomplete or damaged. Write or load the page again.');
  }
}

/** Header and arrays of an inflated blob; arrays are views, not copies. */
export function parse(buffer) {
  const bad = (why) => new Damaged(`The data are not those of a solution (${why}).`);
  if (buffer.byteLength < 16) throw bad('too short');
  const bytes = new Uint8Array(buffer);
  if (String.fromCharCode(...bytes.subarray(0, 8)) !== MAGIC) throw bad('another format or version');
  const length = new DataView(buffer).getUint32(8, true);
  const start = 16 + length;
  if (start > buffer.byteLength || start % 8) throw bad('the header is cut');
  let header;
  try {
    header = JSON.parse(new TextDecoder().decode(bytes.subarray(16, start)));
  } catch {
    throw bad('the header cannot be read');
  }
  const arrays = {};
  for (const [name, { type, offset, length: count }] of Object.entries(header.arrays ?? {})) {
    const Kind = TYPES[type];
    if (!Kind || !Number.isInteger(offset) || !Number.isInteger(count) || offset < 0 || count < 0 || offset % 8 ||
        start + offset + count * Kind.BYTES_PER_ELEMENT > buffer.byteLength) {
      throw bad(`array ${name}`);
    }
    arrays[name] = new Kind(buffer, start + offset, count);
  }
  check(header, arrays, bad);
  return { ...header, arrays };
}

/** What drawing relies on: counts that fit each other, indices within. */
function check(header, arrays, bad) {
  const vertices = header.mesh?.vertices;
  const sizes = { position: 3, uv: 2, surface: 1 };
  for (const [name, n] of Object.entries(sizes)) {
    if (arrays[name]?.length !== n * vertices) throw bad(`${name} does not fit the mesh`);
  }
  if (!arrays.index || arrays.index.length % 3 || arrays.index.some((i) => i >= vertices)) throw bad('index');
  if (arrays.surface.some((s) => s >= header.surfaces.length)) throw bad('surface');
  for (const [name, a] of Object.entries(arrays)) {
    if (/^irradiance\d+$/.test(name) && a.length !== 3 * vertices) throw bad(name);
  }
}

/** Bytes of base64 text, piece by piece. */
export function fromBase64(text, progress = () => {}) {
  const PIECE = 1 << 22;
  const chunks = [];
  for (let at = 0; at < text.length; at += PIECE) {
    let raw;
    try {
      raw = atob(text.slice(at, at + PIECE));
    } catch {
      throw new Damaged('The data in this file are damaged. Write it again with zonal export.');
    }
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    chunks.push(bytes);
    progress(Math.min(1, (at + PIECE) / text.length));
  }
  return chunks;
}

/** Reads a response while telling how far it is. */
export async function download(url, progress = () => {}) {
  let response;
  try {
    response = await fetch(url);
  } catch {
    throw new Damaged('The data cannot be reached. Is zonal view still running?');
  }
  if (!response.ok) throw new Damaged(`The data cannot be had (${response.status}). Is zonal view still running?`);
  const total = Number(response.headers.get('content-length')) || 0;
  const reader = response.body.getReader();
  const chunks = [];
  let got = 0;
  for (;;) {
    let step;
    try {
      step = await reader.read();
    } catch {
      throw new Damaged('The data broke off on their way. Load the page again.');
    }
    if (step.done) break;
    chunks.push(step.value);
    got += step.value.length;
    if (total) progress(got / total);
  }
  return chunks;
}
