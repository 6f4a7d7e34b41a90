// The GPU resources of a solution: mesh, textures, panes, medium; relit when light factors change.

import { createTable, createTexture, setTextureParameters } from './gl.js';
import { cross, length } from './vector_math.js';
import { toHalves, VALUES } from './half_float.js';
import { sumGroups, surfaceEmissions } from './relight.js';
import { crackLines, weld } from './cracks.js';
import { SunMaps } from './sun_maps.js';

/** Largest number of pane triangles that are depth-sorted for every frame. */
const MAX_SORTED_TRIANGLES = 30000;

/** Decodes the pictures as textures of linear light and reports the progress. */
async function loadTextures(gl, scene, progress) {
  const anisotropic = gl.getExtension('EXT_texture_filter_anisotropic');
  const maxSize = gl.getParameter(gl.MAX_TEXTURE_SIZE);
  const out = [];
  for (let i = 0; i < scene.textures; i++) {
    const blob = new Blob([scene.arrays[`texture${i}`]], { type: 'image/png' });
    const plain = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
    let bitmap = await createImageBitmap(blob, plain);
    if (Math.max(bitmap.width, bitmap.height) > maxSize) {
      bitmap = await createImageBitmap(blob, { ...plain, resizeWidth: Math.min(bitmap.width, maxSize), resizeHeight: Math.min(bitmap.height, maxSize) });
    }
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, t);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.generateMipmap(gl.TEXTURE_2D);
    setTextureParameters(gl, gl.TEXTURE_2D, gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR, gl.REPEAT);
    if (anisotropic) gl.texParameterf(gl.TEXTURE_2D, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, 4);
    bitmap.close();
    out.push(t);
    progress((i + 1) / scene.textures);
  }
  return out;
}

/** Uploads a vertex attribute. */
function attribute(gl, location, data, size, type, { integer = false, normalized = false } = {}) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(location);
  if (integer) gl.vertexAttribIPointer(location, size, type, 0, 0);
  else gl.vertexAttribPointer(location, size, type, normalized, 0, 0);
  return buffer;
}

/** The triangles grouped by textures, and the run of each group. */
export function groupByTexture(scene) {
  const { index, surface } = scene.arrays;
  const keys = scene.surfaces.map((s) => `${s.texture ?? ''},${s.emissionTexture ?? ''}`);
  const lists = new Map();
  for (let t = 0; t < index.length; t += 3) {
    const s = surface[index[t]];
    if (!lists.has(keys[s])) lists.set(keys[s], { texture: scene.surfaces[s].texture, emissionTexture: scene.surfaces[s].emissionTexture, triangles: [] });
    lists.get(keys[s]).triangles.push(t);
  }
  const order = new Uint32Array(index.length);
  const runs = [];
  let at = 0;
  for (const { triangles, ...material } of lists.values()) {
    runs.push({ ...material, first: at, count: 3 * triangles.length });
    for (const t of triangles) {
      for (let k = 0; k < 3; k++) order[at++] = index[t + k];
    }
  }
  return { order, runs };
}

/** Unit normals at the vertices, as signed 16-bit numbers: of the largest triangle of each, since those of slivers are inaccurate. */
export function normals({ position: p, index }) {
  const out = new Int16Array((4 * p.length) / 3);
  const largest = new Float32Array(p.length / 3);
  for (let t = 0; t < index.length; t += 3) {
    const [i, j, k] = [3 * index[t], 3 * index[t + 1], 3 * index[t + 2]];
    const area = cross([0, 1, 2].map((c) => p[j + c] - p[i + c]), [0, 1, 2].map((c) => p[k + c] - p[i + c]));
    const size = length(area);
    for (const v of [i, j, k]) {
      if (!(size > largest[v / 3])) continue;
      largest[v / 3] = size;
      area.forEach((x, c) => (out[(4 * v) / 3 + c] = Math.round((32767 * x) / size)));
    }
  }
  return out;
}

function createMesh(gl, scene) {
  const { arrays } = scene;
  const ids = weld(arrays.position);
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const light = attribute(gl, 3, new Float32Array(arrays.position.length), 3, gl.FLOAT);
  const buffers = [
    attribute(gl, 0, arrays.position, 3, gl.FLOAT), attribute(gl, 1, arrays.uv, 2, gl.FLOAT),
    attribute(gl, 2, arrays.surface, 1, gl.UNSIGNED_SHORT, { integer: true }), light, attribute(gl, 4, normals(arrays), 4, gl.SHORT, { normalized: true }),
  ];
  if (arrays.curve) buffers.push(attribute(gl, 5, arrays.curve, 4, gl.FLOAT));
  else gl.vertexAttrib4f(5, 0, 0, 0, 0);
  const triangles = groupByTexture(scene);
  const edges = crackLines(triangles, ids, arrays.position);
  const lists = [[triangles.order, triangles.runs], [edges.lines, edges.runs]].map(([data, runs]) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    buffers.push(buffer);
    return { buffer, runs };
  });
  gl.bindVertexArray(null);
  return { array, light, buffers, triangles: lists[0], cracks: lists[1] };
}

function createPanes(gl, scene) {
  const { panePosition, paneNormal, paneOf, paneIndex } = scene.arrays;
  if (!paneIndex?.length) return null;
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const light = attribute(gl, 3, new Float32Array(panePosition.length), 3, gl.FLOAT);
  const order = gl.createBuffer();
  const buffers = [
    attribute(gl, 0, panePosition, 3, gl.FLOAT), attribute(gl, 1, paneNormal, 3, gl.FLOAT),
    attribute(gl, 2, paneOf, 1, gl.UNSIGNED_SHORT, { integer: true }), light, order,
  ];
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, order);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, paneIndex, gl.DYNAMIC_DRAW);
  gl.bindVertexArray(null);
  const count = paneIndex.length / 3;
  const centres = new Float32Array(3 * count);
  for (let t = 0; t < count; t++) {
    for (let b = 0; b < 3; b++) {
      centres[3 * t + b] = (panePosition[3 * paneIndex[3 * t] + b] + panePosition[3 * paneIndex[3 * t + 1] + b] + panePosition[3 * paneIndex[3 * t + 2] + b]) / 3;
    }
  }
  const depths = createTable(gl, scene.panes.map((p) => [[...p.depth, 0]]), 1);
  return { array, light, order, buffers, count, centres, index: paneIndex, table: depths, sortedFrom: null };
}

/** Halves the resolution of a grid of three values a cell by means over eight cells. */
export function halveResolution(values, [nz, ny, nx]) {
  const small = [nz, ny, nx].map((n) => Math.ceil(n / 2));
  const out = new Float32Array(3 * small[0] * small[1] * small[2]);
  let at = 0;
  for (let x = 0; x < small[2]; x++) {
    for (let y = 0; y < small[1]; y++) {
      for (let z = 0; z < small[0]; z++) {
        const sums = [0, 0, 0];
        let n = 0;
        for (let k = 0; k < 8; k++) {
          const [i, j, l] = [2 * x + (k >> 2), 2 * y + ((k >> 1) & 1), 2 * z + (k & 1)];
          if (i >= nx || j >= ny || l >= nz) continue;
          n++;
          const from = 3 * ((i * ny + j) * nz + l);
          for (let b = 0; b < 3; b++) sums[b] += values[from + b];
        }
        for (let b = 0; b < 3; b++) out[at++] = sums[b] / n;
      }
    }
  }
  return { values: out, dims: small };
}

function createVolume(gl, scene, maxSize) {
  const v = scene.volume;
  if (!v) return null;
  const texture = () => {
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_3D, t);
    setTextureParameters(gl, gl.TEXTURE_3D, gl.LINEAR, gl.LINEAR, gl.CLAMP_TO_EDGE);
    return t;
  };
  const fill = (t, values, dims, scale) => {
    let grid = { values, dims };
    while (Math.max(...grid.dims) > maxSize) grid = halveResolution(grid.values, grid.dims);
    const scaled = scale === 1 ? grid.values : grid.values.map((x) => x / scale);
    gl.bindTexture(gl.TEXTURE_3D, t);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB16F, ...grid.dims, 0, gl.RGB, gl.HALF_FLOAT, toHalves(scaled));
  };
  // The array is [x][y][z]: z is the first axis of the texture.
  const dims = [v.dims[2], v.dims[1], v.dims[0]];
  const constant = (name) => {
    const t = texture();
    const halves = scene.arrays[name];
    if (halves) fill(t, Float32Array.from(halves, (h) => VALUES[h] * v[`${name}Scale`]), dims, 1);
    else fill(t, Float32Array.from(v[name]), [1, 1, 1], 1);
    return t;
  };
  const [extinction, albedo] = ['extinction', 'albedo'].map(constant);
  const cell = v.dims.map((n, k) => (v.max[k] - v.min[k]) / n);
  return { extinction, albedo, radiosity: texture(), fill, dims, cell: Math.min(...cell), min: v.min, max: v.max, unit: 1 };
}

/** All GPU resources of a solution. */
export class Scene {
  static async load(gl, data, progress, small) {
    const s = new Scene();
    s.gl = gl;
    s.data = data;
    s.textures = await loadTextures(gl, data, progress);
    s.white = createTexture(gl, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, 1, 1, new Uint8Array([255, 255, 255, 255]));
    s.mesh = createMesh(gl, data);
    s.panes = createPanes(gl, data);
    s.volume = createVolume(gl, data, Math.min(gl.getParameter(gl.MAX_3D_TEXTURE_SIZE), small ? 96 : 256));
    s.suns = new SunMaps(gl, data, s, small);
    return s;
  }

  /** Frees all resources. */
  free() {
    const { gl } = this;
    for (const part of [this.mesh, this.panes].filter(Boolean)) {
      gl.deleteVertexArray(part.array);
      part.buffers.forEach((b) => gl.deleteBuffer(b));
    }
    this.suns.free();
    const { extinction, albedo, radiosity } = this.volume ?? {};
    const textures = [...this.textures, this.white, this.surfaces, this.panes?.table, extinction, albedo, radiosity];
    textures.forEach((t) => t && gl.deleteTexture(t));
  }

  /** Sums the light of all groups; `field` is the vertex field of the mesh: total, direct or indirect irradiance, or the error estimate. */
  relight(factors, field = 'total') {
    const { gl, data } = this;
    const error = field === 'error';
    this.values = error
      ? Float32Array.from(data.arrays.error, (h) => VALUES[h] * data.mesh.errorScale)
      : sumGroups(data, field === 'total' ? ['indirect', 'direct'] : [field], factors, data.arrays.position.length);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.mesh.light);
    gl.bufferData(gl.ARRAY_BUFFER, this.values, gl.DYNAMIC_DRAW);
    if (this.surfaces) gl.deleteTexture(this.surfaces);
    const emitted = surfaceEmissions(data, factors);
    this.surfaces = createTable(gl, data.surfaces.map((s, i) => [[...s.reflectance, s.both ? 1 : 0], [...emitted[i], 0]]), 2);
    if (this.panes) {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.panes.light);
      gl.bufferData(gl.ARRAY_BUFFER, sumGroups(data, ['pane'], factors, data.arrays.panePosition.length), gl.DYNAMIC_DRAW);
    }
    if (this.volume) {
      const v = this.volume;
      const light = sumGroups(data, ['volume'], factors, 3 * v.dims[0] * v.dims[1] * v.dims[2]);
      // Sunlight has no values here: its share is drawn.
      const sun = (data.suns ?? []).reduce((m, s) => Math.max(m, ...s.irradiance.map((e) => (e * factors[s.group]) / 4)), 0);
      v.unit = Math.max(light.reduce((m, x) => Math.max(m, x), sun) / 1000, 1e-30);
      v.fill(v.radiosity, light, v.dims, v.unit);
    }
  }

  /** Sorts the pane triangles from far to near as seen from `eye`. */
  sortPanes(eye) {
    const p = this.panes;
    if (!p || p.count > MAX_SORTED_TRIANGLES || (p.sortedFrom && p.sortedFrom.every((x, k) => x === eye[k]))) return;
    p.sortedFrom = [...eye];
    const distance2 = new Float32Array(p.count);
    for (let t = 0; t < p.count; t++) {
      distance2[t] = (p.centres[3 * t] - eye[0]) ** 2 + (p.centres[3 * t + 1] - eye[1]) ** 2 + (p.centres[3 * t + 2] - eye[2]) ** 2;
    }
    const order = Uint32Array.from(distance2.keys()).sort((a, b) => distance2[b] - distance2[a]);
    const index = new Uint32Array(3 * p.count);
    order.forEach((t, i) => index.set(p.index.subarray(3 * t, 3 * t + 3), 3 * i));
    this.gl.bindVertexArray(p.array);
    this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER, p.order);
    this.gl.bufferData(this.gl.ELEMENT_ARRAY_BUFFER, index, this.gl.DYNAMIC_DRAW);
    this.gl.bindVertexArray(null);
  }
}
