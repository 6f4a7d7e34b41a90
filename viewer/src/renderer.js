// A frame: surfaces, then panes from far to near, then the medium at a smaller size, then all of it together for the screen.

import { FINAL, HAZE, MESH, PANE } from './shaders.js';
import { flat, program, targets } from './gl.js';
import { frame, scale, viewProjection } from './maths.js';
import { background } from './relight.js';
import { map, LUMINANCE } from './colour.js';

/** Which bands a single value is made of. */
export const BANDS = { mean: [1 / 3, 1 / 3, 1 / 3], luminance: LUMINANCE, red: [1, 0, 0], green: [0, 1, 0], blue: [0, 0, 1] };

/** How a frame ends: for the eye, as colours of the map, or as linear radiance. */
const FINISH = { picture: 0, map: 1, linear: 2 };

export class Renderer {
  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    this.programs = {
      mesh: program(gl, MESH),
      pane: program(gl, PANE),
      tint: program(gl, { vertex: PANE.vertex, fragment: PANE.tint }),
      haze: program(gl, HAZE),
      final: program(gl, FINAL),
    };
    const fine = new Float32Array(4 * 256);
    for (let i = 0; i < 256; i++) fine.set([...map(i / 255), 1], 4 * i);
    this.colours = flat(gl, gl.RGBA16F, gl.RGBA, gl.FLOAT, 256, 1, fine, gl.LINEAR);
    this.samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
    this.screen = gl.createVertexArray();
    this.made = null;
    const { bounds } = scene.data;
    this.diagonal = Math.hypot(...bounds[1].map((x, k) => x - bounds[0][k]));
  }

  /** Targets of a size, kept from frame to frame. */
  targets(width, height, hazeScale) {
    const key = `${width} ${height} ${hazeScale}`;
    if (this.made?.key !== key) {
      this.made?.what.free();
      this.made = { key, what: targets(this.gl, width, height, hazeScale, this.samples, Boolean(this.scene.volume)) };
    }
    return this.made.what;
  }

  /** What the camera sees, in the units of the shaders. */
  view(camera, aspect) {
    const f = frame(camera, aspect);
    // From outside the scene the near plane may be farther off.
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
   * Draws. `look`: camera, exposure, density, show ('picture', 'irradiance', 'radiosity', 'error'), range, hideBacks, factors.
   * `quality`: hazeScale, steps, jitter. `finish`: where it goes ('picture', 'linear').
   */
  draw(look, width, height, quality, into = null, finish = 'picture') {
    const { gl, scene } = this;
    const picture = look.show === 'picture';
    const t = this.targets(width, height, quality.hazeScale);
    const view = this.view(look.camera, width / height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.smooth);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    const back = picture ? background(scene.data, look.factors).map((x) => Math.min(x * look.exposure, 60000)) : [0.0045, 0.005, 0.006];
    gl.clearColor(...back, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawMesh(look, view, picture);
    if (picture && scene.panes && !look.bare) this.drawPanes(look, view);
    gl.disable(gl.DEPTH_TEST);
    if (t.smooth !== t.plain) {
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, t.smooth);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, t.plain);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT, gl.NEAREST);
    }
    const hazy = picture && t.haze && look.density > 0;
    if (hazy) this.drawHaze(look, view, t, quality);
    gl.bindFramebuffer(gl.FRAMEBUFFER, into);
    gl.viewport(0, 0, width, height);
    this.programs.final.use({
      image: [0, gl.TEXTURE_2D, t.image], depth: [1, gl.TEXTURE_2D, t.depth], hazy,
      scattered: [2, gl.TEXTURE_2D, hazy ? t.haze.scattered : t.image], passed: [3, gl.TEXTURE_2D, hazy ? t.haze.passed : t.image],
      ...view.lens, finish: FINISH[finish === 'linear' ? 'linear' : picture ? 'picture' : 'map'],
    });
    this.fill();
  }

  fill() {
    const { gl } = this;
    gl.bindVertexArray(this.screen);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindVertexArray(null);
  }

  drawMesh(look, view, picture) {
    const { gl, scene } = this;
    const p = this.programs.mesh;
    const [low, high] = look.range ?? [0, 1];
    const log = Boolean(look.log);
    const ends = log ? [Math.log2(low), Math.log2(high)] : [low, high];
    p.use({
      viewProjection: view.matrix, eye: look.camera.eye, exposure: look.exposure, surfaces: [0, gl.TEXTURE_2D, scene.surfaces],
      colours: [3, gl.TEXTURE_2D, this.colours], hideBacks: Boolean(look.hideBacks),
      show: picture ? 0 : look.show === 'radiosity' ? 1 : 2,
      range: [ends[0], 1 / (ends[1] - ends[0] || 1), log ? 1 : 0, 0], weights: BANDS[look.band ?? 'mean'],
    });
    gl.bindVertexArray(scene.mesh.array);
    for (const [kind, list, seams] of [[gl.TRIANGLES, scene.mesh.triangles, false], [gl.LINES, scene.mesh.seams, true]]) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list.buffer);
      p.set('seams', seams);
      for (const run of list.runs) {
        p.set('albedo', [1, gl.TEXTURE_2D, scene.textures[run.texture] ?? scene.white]);
        p.set('glow', [2, gl.TEXTURE_2D, scene.textures[run.emissionTexture] ?? scene.white]);
        gl.drawElements(kind, run.count, gl.UNSIGNED_INT, 4 * run.first);
      }
    }
    gl.bindVertexArray(null);
  }

  drawPanes(look, view) {
    const { gl, scene } = this;
    scene.sortPanes(look.camera.eye);
    this.programs.pane.use({
      viewProjection: view.matrix, eye: look.camera.eye, exposure: look.exposure, panes: [0, gl.TEXTURE_2D, scene.panes.table],
    });
    gl.depthMask(false);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.SRC_ALPHA);
    gl.bindVertexArray(scene.panes.array);
    for (let b = 0; b < 3; b++) {
      this.programs.pane.set('band', b);
      gl.colorMask(b === 0, b === 1, b === 2, false);
      gl.drawElements(gl.TRIANGLES, 3 * scene.panes.count, gl.UNSIGNED_INT, 0);
    }
    gl.colorMask(true, true, true, true);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }

  drawHaze(look, view, t, quality) {
    const { gl, scene } = this;
    const { haze } = t;
    const v = scene.volume;
    gl.viewport(0, 0, haze.width, haze.height);
    if (scene.panes) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, haze.tinting);
      gl.clearColor(1, 1, 1, 60000);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.enable(gl.BLEND);
      gl.blendEquationSeparate(gl.FUNC_ADD, gl.MIN);
      gl.blendFuncSeparate(gl.ZERO, gl.SRC_COLOR, gl.ONE, gl.ONE);
      this.programs.tint.use({
        viewProjection: view.matrix, eye: look.camera.eye, ahead: view.forward, planes: [view.near, view.far],
        panes: [0, gl.TEXTURE_2D, scene.panes.table], depth: [1, gl.TEXTURE_2D, t.depth], size: [haze.width, haze.height],
      });
      gl.bindVertexArray(scene.panes.array);
      gl.drawElements(gl.TRIANGLES, 3 * scene.panes.count, gl.UNSIGNED_INT, 0);
      gl.blendEquation(gl.FUNC_ADD);
      gl.disable(gl.BLEND);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, haze.frame);
    this.programs.haze.use({
      depth: [0, gl.TEXTURE_2D, t.depth], tint: [1, gl.TEXTURE_2D, haze.tint],
      extinction: [2, gl.TEXTURE_3D, v.extinction], radiosity: [3, gl.TEXTURE_3D, v.radiosity],
      eye: look.camera.eye, ...view.lens, low: v.min, high: v.max, density: look.density,
      exposure: (look.exposure * v.unit) / Math.PI, stride: v.cell * quality.stride, most: quality.steps,
      shift: quality.jitter ?? 0, tinted: Boolean(scene.panes),
    });
    this.fill();
  }

  /** Linear radiance, W/(m² sr), of a small picture: four floats a pixel, row 0 at the bottom. */
  linear(look, width, height, quality) {
    const { gl } = this;
    const image = flat(gl, gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, width, height, null);
    const frameBuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frameBuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, image, 0);
    this.draw(look, width, height, quality, frameBuffer, 'linear');
    const out = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, out);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frameBuffer);
    gl.deleteTexture(image);
    return out.map((x) => x / look.exposure);
  }
}
