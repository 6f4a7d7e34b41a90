// A thin layer over WebGL2: programs with their uniforms, textures, targets.

/** Compiles and links; uniforms are set by name from an object. */
export function program(gl, { vertex, fragment }) {
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
    uniforms.set(name, { type, at: gl.getUniformLocation(p, name) });
  }
  const setters = {
    [gl.FLOAT]: (at, v) => gl.uniform1f(at, v),
    [gl.FLOAT_VEC2]: (at, v) => gl.uniform2fv(at, v),
    [gl.FLOAT_VEC3]: (at, v) => gl.uniform3fv(at, v),
    [gl.FLOAT_VEC4]: (at, v) => gl.uniform4fv(at, v),
    [gl.FLOAT_MAT4]: (at, v) => gl.uniformMatrix4fv(at, false, v),
  };
  return {
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

/** A texture of floats or bytes without mipmaps. */
export function flat(gl, internal, format, type, width, height, data, filter = gl.NEAREST) {
  const t = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, t);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
  parameters(gl, gl.TEXTURE_2D, filter, filter, gl.CLAMP_TO_EDGE);
  return t;
}

export function parameters(gl, target, min, mag, wrap) {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, min);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, mag);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrap);
  if (target === gl.TEXTURE_3D) gl.texParameteri(target, gl.TEXTURE_WRAP_R, wrap);
}

/** A small table as a texture of single floats, 512 texels wide; `rows` rows for each 512 entries. */
export function table(gl, entries, rows) {
  const blocks = Math.max(1, Math.ceil(entries.length / 512));
  const data = new Float32Array(4 * 512 * rows * blocks);
  entries.forEach((entry, i) => {
    entry.forEach((v, r) => data.set(v, 4 * ((i & 511) + 512 * (rows * (i >> 9) + r))));
  });
  return flat(gl, gl.RGBA32F, gl.RGBA, gl.FLOAT, 512, rows * blocks, data);
}

/** What frames are drawn into: smooth edges first, then plain textures of colour and depth, and the medium at a smaller size. */
export function targets(gl, width, height, hazeScale, samples, haze) {
  const made = { textures: [], buffers: [], frames: [] };
  const texture = (internal, format, type, w, h, filter) => {
    const t = flat(gl, internal, format, type, w, h, null, filter);
    made.textures.push(t);
    return t;
  };
  const colour = (w, h, filter = gl.NEAREST) => texture(gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, w, h, filter);
  const frame = (attachments) => {
    const f = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, f);
    for (const [point, what] of attachments) {
      if (what instanceof WebGLTexture) gl.framebufferTexture2D(gl.FRAMEBUFFER, point, gl.TEXTURE_2D, what, 0);
      else gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, what);
    }
    gl.drawBuffers(attachments.filter(([p]) => p !== gl.DEPTH_ATTACHMENT).map(([p]) => p));
    made.frames.push(f);
    return f;
  };
  const buffer = (internal) => {
    const b = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, b);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, internal, width, height);
    made.buffers.push(b);
    return b;
  };
  const image = colour(width, height);
  const depth = texture(gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, width, height);
  const plain = frame([[gl.COLOR_ATTACHMENT0, image], [gl.DEPTH_ATTACHMENT, depth]]);
  const smooth = samples > 1
    ? frame([[gl.COLOR_ATTACHMENT0, buffer(gl.RGBA16F)], [gl.DEPTH_ATTACHMENT, buffer(gl.DEPTH_COMPONENT24)]])
    : plain;
  const out = { width, height, image, depth, plain, smooth, haze: null };
  if (haze) {
    const w = Math.max(1, Math.round(width * hazeScale));
    const h = Math.max(1, Math.round(height * hazeScale));
    const scattered = colour(w, h);
    const passed = colour(w, h);
    const tint = colour(w, h);
    out.haze = {
      width: w, height: h, scattered, passed, tint,
      frame: frame([[gl.COLOR_ATTACHMENT0, scattered], [gl.COLOR_ATTACHMENT1, passed]]),
      tinting: frame([[gl.COLOR_ATTACHMENT0, tint]]),
    };
  }
  out.free = () => {
    made.frames.forEach((f) => gl.deleteFramebuffer(f));
    made.textures.forEach((t) => gl.deleteTexture(t));
    made.buffers.forEach((b) => gl.deleteRenderbuffer(b));
  };
  return out;
}
