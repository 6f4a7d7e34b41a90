// Shader programs. Radiances are drawn times the exposure, so that half floats hold them for any unit.

import { sunCode } from './sun_shader.js';

const HEAD = `#version 300 es
precision highp float;
precision highp int;
`;

const NOISE = `
float noise(vec2 p) { return fract(52.9829189 * fract(0.06711056 * p.x + 0.00583715 * p.y)); }
float linearDepth(float z, vec2 planes) {
  return 2.0 * planes.x * planes.y / (planes.y + planes.x - (2.0 * z - 1.0) * (planes.y - planes.x));
}`;

/** Surfaces in the light of `suns` suns. */
export const mesh = (suns) => ({
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in uint surface;
layout(location = 3) in vec3 irradiance;
layout(location = 4) in vec3 normal;
// On a curved surface its unit normal, and the height of the surface above the facet, m; zero on a flat one.
layout(location = 5) in vec4 curve;
uniform mat4 viewProjection;
uniform vec3 eye;
uniform bool cracks;
// Centroid interpolation: extrapolation beyond a triangle would be too bright or negative where the light is steep.
centroid out vec2 vUv;
centroid out vec3 vH;
centroid out vec3 vPoint;
centroid out vec4 vCurve;
flat out vec3 vNormal;
flat out int vSurface;
flat out int vAway;
void main() {
  vAway = cracks && dot(normal, eye - position) <= 0.0 ? 1 : 0;
  vUv = uv;
  vH = irradiance;
  vPoint = position;
  vNormal = normal;
  vCurve = curve;
  vSurface = int(surface);
  gl_Position = viewProjection * vec4(position, 1.0);
  // Crack lines lie slightly behind the surfaces whose gaps they close.
  if (cracks) gl_Position.z += 1e-6 * gl_Position.w;
}`,
  // B = E + ρH; the back of a one-sided surface is black, or discarded. Without E for a part of the light.
  fragment: `${HEAD}${NOISE}${sunCode(suns)}
centroid in vec2 vUv;
centroid in vec3 vH;
centroid in vec3 vPoint;
centroid in vec4 vCurve;
flat in vec3 vNormal;
flat in int vSurface;
flat in int vAway;
uniform highp sampler2D surfaces;
uniform sampler2D albedo, emission, colours;
uniform float exposure, emitted, baked;
uniform int show;
uniform bool hideBacks, cracks;
uniform float crackInset;
uniform vec4 range;
uniform vec3 weights;
out vec4 colour;
void main() {
  ivec2 at = ivec2(vSurface & 511, 2 * (vSurface >> 9));
  vec4 reflectance = texelFetch(surfaces, at, 0);
  if (!gl_FrontFacing || vAway == 1) {
    if (hideBacks || reflectance.a > 0.5 || vAway == 1) discard;
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  vec3 rho = min(reflectance.rgb * texture(albedo, vUv).rgb, 1.0);
  vec3 n = normalize(vNormal);
  float turn = noise(gl_FragCoord.xy);
  vec3 lit = vPoint;
  if (dot(vCurve.xyz, vCurve.xyz) > 0.1) {
    // Sunlight falls on the curved surface for which the facet stands.
    lit += vCurve.w * n;
    n = normalize(vCurve.xyz);
  }
  vec3 sun = sunlight(lit, n, turn);
  if (cracks && sun != vec3(0.0)) {
    // A line along an edge is lit only where both sides are.
    vec3 side = crackInset * normalize(cross(n, abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec3 other = cross(n, side);
    sun = min(min(sunlight(lit + side, n, turn), sunlight(lit - side, n, turn)), min(sunlight(lit + other, n, turn), sunlight(lit - other, n, turn)));
  }
  vec3 H = baked * vH + sun;
  vec3 B = emitted * texelFetch(surfaces, at + ivec2(0, 1), 0).rgb * texture(emission, vUv).rgb + rho * H;
  if (show == 0) {
    colour = vec4(min(B * (exposure / 3.14159265359), 60000.0), 1.0);
    return;
  }
  if (show == 3) {
    colour = vec4(min(H * exposure, 60000.0), 1.0);
    return;
  }
  float value = dot(weights, show == 1 ? B : H);
  float t = range.z > 0.5 ? (log2(max(value, 1e-35)) - range.x) * range.y : (value - range.x) * range.y;
  colour = vec4(texture(colours, vec2(clamp(t, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb, 1.0);
}`,
});

export const PANE = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint pane;
layout(location = 3) in vec3 radiosity;
uniform mat4 viewProjection;
out vec3 vPoint;
out vec3 vB;
flat out vec3 vNormal;
flat out int vPane;
void main() {
  vPoint = position;
  vB = radiosity;
  vNormal = normal;
  vPane = int(pane);
  gl_Position = viewProjection * vec4(position, 1.0);
}`,
  // One band a pass: rgb is the radiance of the pane, a its transmittance.
  fragment: `${HEAD}
in vec3 vPoint;
in vec3 vB;
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform vec3 eye;
uniform float exposure;
uniform int band;
out vec4 colour;
void main() {
  float cosine = max(abs(dot(normalize(vPoint - eye), vNormal)), 1e-4);
  vec3 passed = exp(-texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine);
  vec3 added = min((1.0 - passed) * vB * (exposure / 3.14159265359), 60000.0);
  colour = vec4(vec3(added[band]), passed[band]);
}`,
  // For the medium: transmittance of all panes along the ray, and distance of the nearest.
  tint: `${HEAD}
in vec3 vPoint;
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform highp sampler2D depth;
uniform vec3 eye, ahead;
uniform vec2 planes;
uniform vec2 size;
out vec4 colour;
void main() {
  float z = texture(depth, gl_FragCoord.xy / size).r;
  float seen = 2.0 * planes.x * planes.y / (planes.y + planes.x - (2.0 * z - 1.0) * (planes.y - planes.x));
  vec3 ray = vPoint - eye;
  if (dot(ray, ahead) > seen) discard;
  float cosine = max(abs(dot(normalize(ray), vNormal)), 1e-4);
  colour = vec4(exp(-texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine), length(ray));
}`,
};

const SCREEN = `${HEAD}
out vec2 at;
void main() {
  at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
  gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}`;

/** The medium in the light of `suns` suns. */
export const medium = (suns) => ({
  vertex: SCREEN,
  // Ray marching: L = Σ τ (1 − exp(−κ d)) (B + Ω G_sun/4)/π over the steps of a ray up to the surface, with one jitter for all steps of a pixel. Sunlight is
  // evaluated at a point of its own in every step.
  fragment: `${HEAD}${NOISE}${sunCode(suns)}
in vec2 at;
uniform highp sampler2D depth;
uniform sampler2D paneTint;
uniform highp sampler3D extinction, radiosity, albedo;
uniform vec3 eye, forward, across, upward, low, high;
uniform vec2 planes;
uniform float density, exposure, stride, shift;
uniform int maxSteps;
uniform bool hasPanes;
layout(location = 0) out vec4 scattered;
layout(location = 1) out vec4 transmittance;
void main() {
  float z = linearDepth(texture(depth, at).r, planes);
  vec3 ray = forward + (2.0 * at.x - 1.0) * across + (2.0 * at.y - 1.0) * upward;
  float end = z * length(ray);
  vec3 dir = normalize(ray);
  vec3 one = (low - eye) / dir, two = (high - eye) / dir;
  vec3 near = min(one, two), far = max(one, two);
  float t0 = max(max(near.x, max(near.y, near.z)), 0.0);
  float t1 = min(min(far.x, min(far.y, far.z)), end);
  vec3 tau = vec3(1.0), sum = vec3(0.0);
  vec4 glass = hasPanes ? texture(paneTint, at) : vec4(1.0, 1.0, 1.0, 1e30);
  if (t1 > t0) {
    int count = clamp(int(ceil((t1 - t0) / stride)), 1, maxSteps);
    float step = (t1 - t0) / float(count);
    float first = t0 + step * (shift < 0.0 ? 0.5 : fract(noise(gl_FragCoord.xy) + shift));
    for (int i = 0; i < count; i++) {
      float t = first + float(i) * step;
      vec3 where = ((eye + dir * t - low) / (high - low)).zyx;
      vec3 kappa = density * texture(extinction, where).rgb;
      vec3 left = exp(-kappa * step);
      vec3 B = texture(radiosity, where).rgb;
${suns ? `      vec2 random = fract(noise(gl_FragCoord.xy) + vec2(0.61803399, 0.75487767) * float(i));
      B += 0.25 * texture(albedo, where).rgb * sunFluence(eye + dir * (t0 + (float(i) + random.x) * step), random.y, fract(7.0 * random.x));
` : ''}      vec3 light = tau * (1.0 - left) * B;
      sum += t > glass.a ? light * glass.rgb : light;
      tau *= left;
    }
  }
  scattered = vec4(min(sum * exposure, 60000.0), end);
  transmittance = vec4(tau, 1.0);
}`,
});

export const FINAL = {
  vertex: SCREEN,
  fragment: `${HEAD}${NOISE}
in vec2 at;
uniform sampler2D image;
uniform highp sampler2D depth;
uniform highp sampler2D scattered;
uniform sampler2D transmittance;
uniform vec3 forward, across, upward;
uniform vec2 planes;
uniform bool hasMedium;
uniform int finish;
out vec4 colour;
vec2 range(vec3 c) {
  return vec2(min(c.r, min(c.g, c.b)), max(c.r, max(c.g, c.b)));
}
vec3 curve(vec3 x) {
  x = max(x, 0.0);
  vec3 t = (x - 0.25) / 0.75;
  vec3 y = mix(x, 0.25 + 0.75 * t / (1.0 + t), greaterThan(x, vec3(0.25)));
  // Mean of the per-band curve and the curve that preserves the hue.
  vec2 from = range(x), to = range(y);
  return 0.5 * (y + to.x + (x - from.x) * (to.y - to.x) / max(from.y - from.x, 1e-12));
}
vec3 srgb(vec3 x) {
  x = clamp(x, 0.0, 1.0);
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}
void main() {
  vec3 L = texture(image, at).rgb;
  if (hasMedium) {
    // Bilateral upsampling: the four nearest samples, weighted by the difference of their distance.
    vec3 ray = forward + (2.0 * at.x - 1.0) * across + (2.0 * at.y - 1.0) * upward;
    float far = linearDepth(texture(depth, at).r, planes) * length(ray);
    ivec2 size = textureSize(scattered, 0);
    vec2 p = at * vec2(size) - 0.5;
    ivec2 base = ivec2(floor(p));
    vec2 f = p - vec2(base);
    vec3 s = vec3(0.0), t = vec3(0.0);
    float total = 0.0;
    for (int k = 0; k < 4; k++) {
      ivec2 o = ivec2(k & 1, k >> 1);
      ivec2 q = clamp(base + o, ivec2(0), size - 1);
      vec4 a = texelFetch(scattered, q, 0);
      float w = (o.x == 1 ? f.x : 1.0 - f.x) * (o.y == 1 ? f.y : 1.0 - f.y) + 1e-3;
      w /= 1e-3 + abs(min(a.a, 6e4) - min(far, 6e4)) / min(far, 6e4);
      s += w * a.rgb;
      t += w * texelFetch(transmittance, q, 0).rgb;
      total += w;
    }
    L = L * (t / total) + s / total;
  }
  if (finish == 2) {
    colour = vec4(L, 1.0);
    return;
  }
  vec3 v = srgb(finish == 1 ? L : curve(L));
  vec2 p = vec2(gl_FragCoord.x, gl_FragCoord.y);
  vec3 d = vec3(noise(p), noise(p + vec2(47.0, 17.0)), noise(p + vec2(94.0, 34.0)));
  colour = vec4(v + (d - 0.5) / 255.0, 1.0);
}`,
};
