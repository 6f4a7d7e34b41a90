// Draws a frame: surfaces, panes from far to near, the medium at reduced size, then composition and tone mapping.

import { FINAL, PANE, medium, mesh } from './shaders.js';
import { createProgram, createTargets, createTexture } from './gl.js';
import { frame, scale, viewProjection } from './vector_math.js';
import { background } from './relight.js';
import { LUMINANCE, mapColour } from './colour.js';

/** Weights of the bands in a single value. */
export const BAND_WEIGHTS = { mean: [1 / 3, 1 / 3, 1 / 3], luminance: LUMINANCE, red: [1, 0, 0], green: [0, 1, 0], blue: [0, 0, 1] };

/** Texture unit of the albedo of the medium, behind those of the suns. */
const ALBEDO_UNIT = 13;
/** Rays to each sun from a surface point, unless the quality says otherwise. */
const SUN_SAMPLES = 32;
/** Bytes of a vertex of the mesh (position, texture, surface, light, normal) and of the panes (position, normal, pane, light). */
const MESH_VERTEX_BYTES = 42;
const PANE_VERTEX_BYTES = 38;

/** Output of a frame: tone-mapped picture, colours of the map, or linear radiance. */
const OUTPUT = { picture: 0, map: 1, linear: 2 };

export class Renderer {
  constructor(gl, scene) {
    this.gl = gl;
    this.programs = {
      pane: createProgram(gl, PANE),
      tint: createProgram(gl, { vertex: PANE.vertex, fragment: PANE.tint }),
      final: createProgram(gl, FINAL),
    };
    /** Draw calls of the last frame, and the bytes of indices and vertices that they read. */
    this.counts = { calls: 0, bytes: 0 };
    const colours = new Float32Array(4 * 256);
    for (let i = 0; i < 256; i++) colours.set([...mapColour(i / 255), 1], 4 * i);
    this.colours = createTexture(gl, gl.RGBA16F, gl.RGBA, gl.FLOAT, 256, 1, colours, gl.LINEAR);
    this.samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
    this.screen = gl.createVertexArray();
    this.cached = null;
    this.show(scene);
  }

  /** Draws this scene from now on. */
  show(scene) {
    const { gl, programs } = this;
    if (this.scene?.suns.count !== scene.suns.count) {
      for (const name of ['mesh', 'medium']) programs[name]?.free();
      Object.assign(programs, { mesh: createProgram(gl, mesh(scene.suns.count)), medium: createProgram(gl, medium(scene.suns.count)) });
    }
    this.scene = scene;
    const { bounds } = scene.data;
    this.diagonal = Math.hypot(...bounds[1].map((x, k) => x - bounds[0][k]));
  }

  /** Render targets of a size, cached between frames. */
  targets(width, height, mediumScale) {
    const key = `${width} ${height} ${mediumScale}`;
    if (this.cached?.key !== key) {
      this.cached?.targets.free();
      this.cached = { key, targets: createTargets(this.gl, width, height, mediumScale, this.samples, Boolean(this.scene.volume)) };
    }
    return this.cached.targets;
  }

  /** View matrix and frustum of a camera. */
  view(camera, aspect) {
    const f = frame(camera, aspect);
    // Outside of the scene the near plane may be more distant.
    const { bounds } = this.scene.data;
    const outside = Math.hypot(...[0, 1, 2].map((k) => Math.max(bounds[0][k] - camera.eye[k], 0, camera.eye[k] - bounds[1][k])));
    const near = Math.max(4e-4 * this.diagonal, 0.2 * outside);
    const far = 1.1 * this.diagonal + outside + near;
    return {
      ...f, near, far,
      matrix: viewProjection(camera.eye, f, near, far),
      lens: { forward: f.forward, across: scale(f.right, f.tanX), upward: scale(f.up, f.tanY), planes: [near, far] },
    };
  }

  /**
   * Draws a frame. `settings`: camera, exposure, density, show ('picture', 'irradiance', 'radiosity', 'error'), part ('total', 'direct', 'indirect', or
   * 'sun' for drawn sunlight alone), range,
   * hideBacks, factors. `quality`: mediumScale, steps, stride, jitter, sunSamples. `output`: 'picture' or 'linear'; linear irradiance is in W/m².
   */
  draw(settings, width, height, quality, into = null, output = 'picture') {
    const { gl, scene } = this;
    const picture = settings.show === 'picture';
    scene.suns.prepare();
    this.counts = { calls: 0, bytes: 0 };
    const t = this.targets(width, height, quality.mediumScale);
    const view = this.view(settings.camera, width / height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.multisampled);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    const clear = picture ? background(scene.data, settings.factors).map((x) => Math.min(x * settings.exposure, 60000)) : [0.0045, 0.005, 0.006];
    gl.clearColor(...clear, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawMesh(settings, view, quality, output);
    if (picture && scene.panes && !settings.withoutPanes) this.drawPanes(settings, view);
    gl.disable(gl.DEPTH_TEST);
    if (t.multisampled !== t.resolved) {
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, t.multisampled);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, t.resolved);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT, gl.NEAREST);
    }
    const hasMedium = picture && t.medium && settings.density > 0;
    if (hasMedium) this.drawMedium(settings, view, t, quality);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.viewport(0, 0, width, height);
    this.programs.final.use({
      image: [0, gl.TEXTURE_2D, t.image], depth: [1, gl.TEXTURE_2D, t.depth], hasMedium,
      scattered: [2, gl.TEXTURE_2D, hasMedium ? t.medium.scattered : t.image], transmittance: [3, gl.TEXTURE_2D, hasMedium ? t.medium.transmittance : t.image],
      ...view.lens, finish: OUTPUT[output === 'linear' ? 'linear' : picture ? 'picture' : 'map'],
    });
    this.drawScreen();
  }

  /** Draws one triangle over the whole screen. */
  drawScreen() {
    const { gl } = this;
    gl.bindVertexArray(this.screen);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
    this.counts.calls++;
  }

  /** Draws indexed elements of vertices of `vertexBytes` bytes each. */
  drawElements(kind, count, offset, vertexBytes) {
    this.gl.drawElements(kind, count, this.gl.UNSIGNED_INT, offset);
    this.counts.calls++;
    this.counts.bytes += count * (4 + vertexBytes);
  }

  /** Uniforms of sunlight: of all suns on what is shown, `scale` times. */
  sunUniforms(settings, quality, scale) {
    const lit = settings.show !== 'error' && settings.part !== 'indirect';
    return this.scene.suns.uniforms(settings.factors, lit ? scale : 0, quality.sunSamples ?? SUN_SAMPLES);
  }

  drawMesh(settings, view, quality, output) {
    const { gl, scene } = this;
    const { show } = settings;
    const part = show === 'picture' ? 'total' : settings.part ?? 'total';
    const p = this.programs.mesh;
    const [low, high] = settings.range ?? [0, 1];
    const log = Boolean(settings.log);
    const ends = log ? [Math.log2(low), Math.log2(high)] : [low, high];
    p.use({
      viewProjection: view.matrix, eye: settings.camera.eye, exposure: settings.exposure, surfaces: [0, gl.TEXTURE_2D, scene.surfaces],
      colours: [3, gl.TEXTURE_2D, this.colours], hideBacks: Boolean(settings.hideBacks),
      show: show === 'picture' ? 0 : show === 'radiosity' ? 1 : output === 'linear' ? 3 : 2, emitted: part === 'total' ? 1 : 0, baked: part === 'sun' ? 0 : 1,
      ...this.sunUniforms({ ...settings, part }, quality, 1),
      range: [ends[0], 1 / (ends[1] - ends[0] || 1), log ? 1 : 0, 0], weights: BAND_WEIGHTS[settings.band ?? 'mean'],
    });
    gl.bindVertexArray(scene.mesh.array);
    for (const [kind, list, cracks] of [[gl.TRIANGLES, scene.mesh.triangles, false], [gl.LINES, scene.mesh.cracks, true]]) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list.buffer);
      p.set('cracks', cracks);
      for (const run of list.runs) {
        p.set('albedo', [1, gl.TEXTURE_2D, scene.textures[run.texture] ?? scene.white]);
        p.set('emission', [2, gl.TEXTURE_2D, scene.textures[run.emissionTexture] ?? scene.white]);
        this.drawElements(kind, run.count, 4 * run.first, MESH_VERTEX_BYTES);
      }
    }
    gl.bindVertexArray(null);
  }

  drawPanes(settings, view) {
    const { gl, scene } = this;
    scene.sortPanes(settings.camera.eye);
    this.programs.pane.use({
      viewProjection: view.matrix, eye: settings.camera.eye, exposure: settings.exposure, panes: [0, gl.TEXTURE_2D, scene.panes.table],
    });
    gl.depthMask(false);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.SRC_ALPHA);
    gl.bindVertexArray(scene.panes.array);
    for (let b = 0; b < 3; b++) {
      this.programs.pane.set('band', b);
      gl.colorMask(b === 0, b === 1, b === 2, false);
      this.drawElements(gl.TRIANGLES, 3 * scene.panes.count, 0, PANE_VERTEX_BYTES);
    }
    gl.colorMask(true, true, true, true);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  drawMedium(settings, view, t, quality) {
    const { gl, scene } = this;
    const { medium } = t;
    const v = scene.volume;
    gl.viewport(0, 0, medium.width, medium.height);
    if (scene.panes) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, medium.paneFrame);
      gl.clearColor(1, 1, 1, 60000);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.enable(gl.BLEND);
      gl.blendEquationSeparate(gl.FUNC_ADD, gl.MIN);
      gl.blendFuncSeparate(gl.ZERO, gl.SRC_COLOR, gl.ONE, gl.ONE);
      this.programs.tint.use({
        viewProjection: view.matrix, eye: settings.camera.eye, ahead: view.forward, planes: [view.near, view.far],
        panes: [0, gl.TEXTURE_2D, scene.panes.table], depth: [1, gl.TEXTURE_2D, t.depth], size: [medium.width, medium.height],
      });
      gl.bindVertexArray(scene.panes.array);
      this.drawElements(gl.TRIANGLES, 3 * scene.panes.count, 0, PANE_VERTEX_BYTES);
      gl.blendEquation(gl.FUNC_ADD);
      gl.disable(gl.BLEND);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, medium.frame);
    this.programs.medium.use({
      depth: [0, gl.TEXTURE_2D, t.depth], paneTint: [1, gl.TEXTURE_2D, medium.paneTint],
      extinction: [2, gl.TEXTURE_3D, v.extinction], radiosity: [3, gl.TEXTURE_3D, v.radiosity],
      eye: settings.camera.eye, ...view.lens, low: v.min, high: v.max, density: settings.density,
      exposure: (settings.exposure * v.unit) / Math.PI, stride: v.cell * quality.stride, maxSteps: quality.steps,
      shift: quality.jitter ?? 0, hasPanes: Boolean(scene.panes), albedo: [ALBEDO_UNIT, gl.TEXTURE_3D, v.albedo],
      ...this.sunUniforms({ ...settings, part: 'total' }, quality, 1 / v.unit),
    });
    this.drawScreen();
  }

  /** Linear radiance, W/(m² sr), or irradiance, W/m², of a small picture: four floats a pixel, row 0 at the bottom. */
  linear(settings, width, height, quality) {
    const { gl } = this;
    const image = createTexture(gl, gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, width, height, null);
    const frameBuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frameBuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, image, 0);
    this.draw(settings, width, height, quality, frameBuffer, 'linear');
    const out = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, out);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frameBuffer);
    gl.deleteTexture(image);
    return out.map((x) => x / settings.exposure);
  }
}
