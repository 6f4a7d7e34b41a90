// Helpers over WebGL 2: programs with uniforms, textures, render targets.

/** Compiles and links a program whose uniforms are set by name from an object; arrays as one list of numbers. */
export function createProgram(gl, { vertex, fragment }) {
  const p = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const s = gl.createShader(kind);
    gl.shaderSource(s, text);
    gl.compileShader(s);
    if (!gl.getShaderParameter(s, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(s));
    gl.attachShader(p, s);
  }
  gl.linkProgram(p);
  if (!gl.getProgramParameter(p, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(p));
  const uniforms = new Map();
  for (let i = 0; i < gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i++) {
    const { name, type } = gl.getActiveUniform(p, i);
    uniforms.set(name.replace(/\[0\]$/, ''), { type, at: gl.getUniformLocation(p, name) });
  }
  const setters = {
    [gl.FLOAT]: (at, v) => gl.uniform1f(at, v),
    [gl.FLOAT_VEC2]: (at, v) => gl.uniform2fv(at, v),
    [gl.FLOAT_VEC3]: (at, v) => gl.uniform3fv(at, v),
    [gl.FLOAT_VEC4]: (at, v) => gl.uniform4fv(at, v),
    [gl.FLOAT_MAT4]: (at, v) => gl.uniformMatrix4fv(at, false, v),
  };
  return {
    free: () => gl.deleteProgram(p),
    /** Makes the program current and sets uniforms; samplers take [unit, target, texture]. */
    use(values) {
      gl.useProgram(p);
      for (const [name, value] of Object.entries(values)) this.set(name, value);
    },
    set(name, value) {
      const u = uniforms.get(name);
      if (!u) return;
      if (Array.isArray(value) && value.length === 3 && value[2] instanceof WebGLTexture) {
        gl.activeTexture(gl.TEXTURE0 + value[0]);
        gl.bindTexture(value[1], value[2]);
        gl.uniform1i(u.at, value[0]);
      } else {
        (setters[u.type] ?? ((at, v) => gl.uniform1i(at, v)))(u.at, value);
      }
    },
  };
}

/** A 2D texture of floats or bytes without mipmaps. */
export function createTexture(gl, internal, format, type, width, height, data, filter = gl.NEAREST) {
  const t = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, t);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
  setTextureParameters(gl, gl.TEXTURE_2D, filter, filter, gl.CLAMP_TO_EDGE);
  return t;
}

/** Sets filters and wrapping of the bound texture. */
export function setTextureParameters(gl, target, min, mag, wrap) {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, min);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, mag);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrap);
  if (target === gl.TEXTURE_3D) gl.texParameteri(target, gl.TEXTURE_WRAP_R, wrap);
}

/** A table as a texture of single floats, 512 texels wide, with `rows` rows for each 512 entries. */
export function createTable(gl, entries, rows) {
  const blocks = Math.max(1, Math.ceil(entries.length / 512));
  const data = new Float32Array(4 * 512 * rows * blocks);
  entries.forEach((entry, i) => {
    entry.forEach((v, r) => data.set(v, 4 * ((i & 511) + 512 * (rows * (i >> 9) + r))));
  });
  return createTexture(gl, gl.RGBA32F, gl.RGBA, gl.FLOAT, 512, rows * blocks, data);
}

/** The render targets: a multisampled framebuffer, textures of colour and depth, and the medium at a reduced size. */
export function createTargets(gl, width, height, mediumScale, samples, hasMedium) {
  const owned = { textures: [], buffers: [], frames: [] };
  const texture = (internal, format, type, w, h, filter) => {
    const t = createTexture(gl, internal, format, type, w, h, null, filter);
    owned.textures.push(t);
    return t;
  };
  const colour = (w, h, filter = gl.NEAREST) => texture(gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, w, h, filter);
  const frame = (attachments) => {
    const f = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, f);
    for (const [point, target] of attachments) {
      if (target instanceof WebGLTexture) gl.framebufferTexture2D(gl.FRAMEBUFFER, point, gl.TEXTURE_2D, target, 0);
      else gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, target);
    }
    gl.drawBuffers(attachments.filter(([p]) => p !== gl.DEPTH_ATTACHMENT).map(([p]) => p));
    owned.frames.push(f);
    return f;
  };
  const buffer = (internal) => {
    const b = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, b);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, internal, width, height);
    owned.buffers.push(b);
    return b;
  };
  const image = colour(width, height);
  const depth = texture(gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, width, height);
  const resolved = frame([[gl.COLOR_ATTACHMENT0, image], [gl.DEPTH_ATTACHMENT, depth]]);
  const multisampled = samples > 1
    ? frame([[gl.COLOR_ATTACHMENT0, buffer(gl.RGBA16F)], [gl.DEPTH_ATTACHMENT, buffer(gl.DEPTH_COMPONENT24)]])
    : resolved;
  const out = { width, height, image, depth, resolved, multisampled, medium: null };
  if (hasMedium) {
    const w = Math.max(1, Math.round(width * mediumScale));
    const h = Math.max(1, Math.round(height * mediumScale));
    const scattered = colour(w, h);
    const transmittance = colour(w, h);
    const paneTint = colour(w, h);
    out.medium = {
      width: w, height: h, scattered, transmittance, paneTint,
      frame: frame([[gl.COLOR_ATTACHMENT0, scattered], [gl.COLOR_ATTACHMENT1, transmittance]]),
      paneFrame: frame([[gl.COLOR_ATTACHMENT0, paneTint]]),
    };
  }
  out.free = () => {
    owned.frames.forEach((f) => gl.deleteFramebuffer(f));
    owned.textures.forEach((t) => gl.deleteTexture(t));
    owned.buffers.forEach((b) => gl.deleteRenderbuffer(b));
  };
  return out;
}
