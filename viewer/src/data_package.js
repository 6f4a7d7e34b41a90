// The data package of a baked solution: format in crates/app/src/pages/viewer/pack.rs.

const MAGIC = 'ZONALVW1';
const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f16: Uint16Array };

/** Data or a device that the viewer cannot use; the message is for the user. */
export class UnusableError extends Error {}

/** Inflates gzip data; its checksum verifies the package. */
export async function inflate(chunks) {
  if (typeof DecompressionStream === 'undefined') {
    throw new UnusableError('This browser cannot decompress the data (DecompressionStream is missing). Use a version of 2023 or later.');
  }
  try {
    const stream = new Blob(chunks).stream().pipeThrough(new DecompressionStream('gzip'));
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new UnusableError('The data are incomplete or damaged. Reload the page or export it again.');
  }
}

/** Header and arrays of an inflated package; arrays are views, not copies. */
export function parse(buffer) {
  const invalid = (why) => new UnusableError(`The data are not a solution (${why}).`);
  if (buffer.byteLength < 16) throw invalid('too short');
  const bytes = new Uint8Array(buffer);
  if (String.fromCharCode(...bytes.subarray(0, 8)) !== MAGIC) throw invalid('unknown format or version');
  const length = new DataView(buffer).getUint32(8, true);
  const start = 16 + length;
  if (start > buffer.byteLength || start % 8) throw invalid('the header is truncated');
  let header;
  try {
    header = JSON.parse(new TextDecoder().decode(bytes.subarray(16, start)));
  } catch {
    throw invalid('the header is not valid JSON');
  }
  const arrays = {};
  for (const [name, { type, offset, length: count }] of Object.entries(header.arrays ?? {})) {
    const Kind = TYPES[type];
    if (!Kind || !Number.isInteger(offset) || !Number.isInteger(count) || offset < 0 || count < 0 || offset % 8 ||
        start + offset + count * Kind.BYTES_PER_ELEMENT > buffer.byteLength) {
      throw invalid(`array ${name}`);
    }
    arrays[name] = new Kind(buffer, start + offset, count);
  }
  validate(header, arrays, invalid);
  return { ...header, arrays };
}

/** Checks the sizes of the arrays and the range of the indices. */
function validate(header, arrays, invalid) {
  const vertices = header.mesh?.vertices;
  const sizes = { position: 3, uv: 2, surface: 1 };
  for (const [name, n] of Object.entries(sizes)) {
    if (arrays[name]?.length !== n * vertices) throw invalid(`size of ${name}`);
  }
  if (arrays.curve && arrays.curve.length !== 4 * vertices) throw invalid('size of curve');
  if (!arrays.index || arrays.index.length % 3 || arrays.index.some((i) => i >= vertices)) throw invalid('index');
  if (arrays.surface.some((s) => s >= header.surfaces.length)) throw invalid('surface');
  for (const [name, a] of Object.entries(arrays)) {
    if (/^(in)?direct\d+$/.test(name) && a.length !== 3 * vertices) throw invalid(name);
  }
}

/** Decodes base64 text in chunks. */
export function fromBase64(text, progress = () => {}) {
  const CHUNK_CHARACTERS = 1 << 22;
  const chunks = [];
  for (let at = 0; at < text.length; at += CHUNK_CHARACTERS) {
    let raw;
    try {
      raw = atob(text.slice(at, at + CHUNK_CHARACTERS));
    } catch {
      throw new UnusableError('The data in this file are damaged. Export it again with zonal export.');
    }
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    chunks.push(bytes);
    progress(Math.min(1, (at + CHUNK_CHARACTERS) / text.length));
  }
  return chunks;
}

/** Downloads a URL and reports the progress. */
export async function download(url, progress = () => {}) {
  let response;
  try {
    response = await fetch(url);
  } catch {
    throw new UnusableError('The server does not answer. Check that zonal view is running.');
  }
  if (!response.ok) throw new UnusableError(`The server answered with status ${response.status}. Check that zonal view is running.`);
  const total = Number(response.headers.get('content-length')) || 0;
  const reader = response.body.getReader();
  const chunks = [];
  let received = 0;
  for (;;) {
    let step;
    try {
      step = await reader.read();
    } catch {
      throw new UnusableError('The download was interrupted. Reload the page.');
    }
    if (step.done) break;
    chunks.push(step.value);
    received += step.value.length;
    if (total) progress(received / total);
  }
  return chunks;
}
