// Shadow maps of the suns: depth of the surfaces, and depth and transmittance of the panes before them, as seen from each sun. They depend on suns and geometry
// alone and are drawn once for a scene.

import { createProgram } from './gl.js';
import { VALUES, toHalves } from './half_float.js';
import { MAX_SUNS, SUN_DEPTH, SUN_TINT, SUN_UNITS } from './sun_shader.js';
import { cross, dot, unit } from './vector_math.js';

/** Sides of the maps in texels: of one sun, of one of several or on a small device. */
const MAP_SIDE = { one: 4096, several: 2048 };
/** Margin of a map over the scene's box. */
const MARGIN = 1.02;
/** Distance on either side of crack lines at which sunlight has to arrive to light them, texels: on edges themselves a map is not reliable. */
const CRACK_TEXELS = 3;
/** Distance of crack lines behind the surfaces in a map, texels. */
const CRACK_DEPTH = 16;
/** Rotations of a map that are tried to make it small. */
const ROTATIONS = 48;

/** Half the size of the box of points about the origin along an axis. */
const extent = (corners, axis) => corners.reduce((m, c) => Math.max(m, Math.abs(dot(c, axis))), 1e-9);

/**
 * Axes and half sizes of the map of a sun over a box that is centred at the origin: { right, up, towards, half: [x, y, z] } with the smallest area over
 * rotations about the direction of light.
 */
export function fitMap(towards, bounds) {
  const corners = Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((k) => bounds[(i >> k) & 1][k]));
  const t = unit(towards);
  const first = unit(cross(Math.abs(t[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], t));
  const second = cross(t, first);
  let best = null;
  for (let i = 0; i < ROTATIONS; i++) {
    const [c, s] = [Math.cos((Math.PI * i) / (2 * ROTATIONS)), Math.sin((Math.PI * i) / (2 * ROTATIONS))];
    const right = first.map((x, k) => c * x + s * second[k]);
    const up = cross(t, right);
    const half = [right, up, t].map((axis) => MARGIN * extent(corners, axis));
    if (!best || half[0] * half[1] < best.half[0] * best.half[1]) best = { right, up, towards: t, half };
  }
  return best;
}

/** The matrix to the space of a map, m: x and y from its lower corner, z from its near side along the light; columns one after the other. */
export function mapSpace({ right, up, towards, half }) {
  const column = (k) => [right[k], up[k], -towards[k], 0];
  return [...column(0), ...column(1), ...column(2), ...half, 1];
}

/** The matrix to clip coordinates of a map. */
export function mapClip({ right, up, towards, half }) {
  const column = (k) => [right[k] / half[0], up[k] / half[1], -towards[k] / half[2], 0];
  return [...column(0), ...column(1), ...column(2), 0, 0, 0, 1];
}

export class SunMaps {
  /** `mesh`, `panes` and `volume` are those of the scene on the GPU. */
  constructor(gl, data, { mesh, panes, volume }, small) {
    const suns = (data.suns ?? []).slice(0, MAX_SUNS);
    Object.assign(this, { gl, suns, mesh, panes, volume });
    this.count = suns.length;
    /** Number of times that the maps were drawn. */
    this.drawn = 0;
    if (!this.count) return;
    this.maps = suns.map((s) => fitMap(s.towards, data.bounds));
    const side = small || this.count > 1 ? MAP_SIDE.several : MAP_SIDE.one;
    this.side = Math.min(side, gl.getParameter(gl.MAX_TEXTURE_SIZE));
    const [paneSide, n] = [panes ? this.side : 1, this.count];
    this.textures = {
      sunOpaque: this.array(gl.DEPTH_COMPONENT24, this.side, n),
      sunNear: this.array(gl.DEPTH_COMPONENT16, paneSide, n),
      sunFar: this.array(gl.DEPTH_COMPONENT16, paneSide, n),
      sunTintNear: this.array(gl.RGB10_A2, paneSide, n),
      sunTintAll: this.array(gl.RGB10_A2, paneSide, n),
    };
    this.depths = suns.map((s, k) => this.depthTexture(s, data.arrays[`sunDepth${k}`]));
    /** Largest edge of a texel, m. */
    this.texel = Math.max(...this.maps.flatMap(({ half }) => [half[0], half[1]])) * 2 / this.side;
    /** Bytes of the maps on the GPU. */
    this.bytes = n * (4 * this.side ** 2 + (panes ? 12 * this.side ** 2 : 0));
  }

  array(format, side, layers) {
    const { gl } = this;
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, t);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, format, side, side, layers);
    for (const p of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, p, gl.NEAREST);
    for (const p of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, p, gl.CLAMP_TO_EDGE);
    return t;
  }

  /** The optical depths towards a sun; zero without a medium. */
  depthTexture(sun, halves) {
    const { gl } = this;
    const t = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_3D, t);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const dims = halves ? [sun.depthDims[2], sun.depthDims[1], sun.depthDims[0]] : [1, 1, 1];
    const values = halves ? toHalves(Float32Array.from(halves, (h) => VALUES[h] * sun.depthScale)) : new Uint16Array(3);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGB16F, ...dims, 0, gl.RGB, gl.HALF_FLOAT, values);
    for (const p of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_3D, p, gl.LINEAR);
    for (const p of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(gl.TEXTURE_3D, p, gl.CLAMP_TO_EDGE);
    return t;
  }

  free() {
    if (!this.count) return;
    [...Object.values(this.textures), ...this.depths].forEach((t) => this.gl.deleteTexture(t));
  }

  /** Draws the maps unless they are there. */
  prepare() {
    if (!this.count || this.drawn) return;
    const { gl } = this;
    const programs = { depth: createProgram(gl, SUN_DEPTH), tint: createProgram(gl, SUN_TINT) };
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.viewport(0, 0, this.side, this.side);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    this.maps.forEach((map, k) => {
      const toMap = mapClip(map);
      this.attach(k, null, 'sunOpaque');
      gl.clearDepth(1);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      programs.depth.use({ toMap });
      gl.bindVertexArray(this.mesh.array);
      for (const [kind, list] of [[gl.TRIANGLES, this.mesh.triangles], [gl.LINES, this.mesh.cracks]]) {
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list.buffer);
        // Crack lines lie behind the surfaces whose gaps they close, since their depths within a texel are not those of its centre.
        programs.depth.set('behind', kind === gl.LINES ? (CRACK_DEPTH * this.texel) / map.half[2] : 0);
        for (const run of list.runs) gl.drawElements(kind, run.count, gl.UNSIGNED_INT, 4 * run.first);
      }
      if (this.panes) this.drawPanes(programs, map, k);
    });
    gl.bindVertexArray(null);
    gl.clearDepth(1);
    gl.depthFunc(gl.LESS);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frame);
    Object.values(programs).forEach((p) => p.free());
    this.drawn++;
  }

  /** Depth and transmittance of the pane nearest to the sun, the product of all panes, and the depth of the last. */
  drawPanes({ tint, depth }, map, k) {
    const { gl, panes } = this;
    const toMap = mapClip(map);
    const draw = () => gl.drawElements(gl.TRIANGLES, 3 * panes.count, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(panes.array);
    gl.clearColor(1, 1, 1, 1);
    tint.use({ toMap, towards: map.towards, layer: k, panes: [0, gl.TEXTURE_2D, panes.table], sunOpaque: [1, gl.TEXTURE_2D_ARRAY, this.textures.sunOpaque] });
    this.attach(k, 'sunTintNear', 'sunNear');
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    draw();
    this.attach(k, 'sunTintAll', 'sunFar');
    gl.clearDepth(0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ZERO, gl.SRC_COLOR);
    draw();
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    // The last pane before a surface: panes behind it are discarded here too.
    gl.depthFunc(gl.GREATER);
    gl.colorMask(false, false, false, false);
    draw();
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LESS);
    gl.clearDepth(1);
  }

  attach(layer, colour, depth) {
    const { gl, textures } = this;
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, colour ? textures[colour] : null, 0, layer);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, textures[depth], 0, layer);
    gl.drawBuffers([colour ? gl.COLOR_ATTACHMENT0 : gl.NONE]);
  }

  /** Uniforms of the shader code of sunlight, with the irradiances times the factors of their groups and `scale`. */
  uniforms(factors, scale, samples) {
    if (!this.count) return {};
    const { gl, suns, maps } = this;
    const out = {
      crackInset: CRACK_TEXELS * this.texel,
      sunSpace: maps.flatMap(mapSpace),
      sunScale: maps.flatMap(({ half }, k) => [...half.map((h) => 0.5 / h), Math.tan(0.5 * suns[k].angularDiameter)]),
      sunLight: suns.flatMap((s) => s.irradiance.map((e) => e * factors[s.group] * scale)),
      sunBoxLow: this.volume?.min ?? [0, 0, 0], sunBoxHigh: this.volume?.max ?? [0, 0, 0],
      sunSamples: samples, sunPanes: Boolean(this.panes),
    };
    for (const [name, texture] of Object.entries(this.textures)) out[name] = [SUN_UNITS[name], gl.TEXTURE_2D_ARRAY, texture];
    this.depths.forEach((t, k) => (out[`sunDepth${k}`] = [SUN_UNITS.sunDepth + k, gl.TEXTURE_3D, t]));
    return out;
  }
}
