// Shader code of sunlight: shadow maps with penumbras, panes, and the depth of the medium.
//
// In the space of a map x and y run across the light and z along it, m. A surface point at (x, y, z) sees the sun as a cone of directions with the tangent a of
// its angular radius: at the distance d before the point, the ray of a point s of the unit disc is s·a·d beside it. The share of rays that no surface blocks and
// their mean transmittance through panes give
//
//     H_dir = E cosθ τ exp(−D)
//
// with D the optical depth of the medium towards the sun, a 3D texture. Blockers are found at few offsets first; then each ray is tested at the distances of the
// nearest and the farthest of them. Depths are compared with the plane of the receiver at the centre of the texel, so that a surface does not shade itself.

/** Texture units of the maps; the depths of suns follow. */
export const SUN_UNITS = { sunOpaque: 4, sunNear: 5, sunFar: 6, sunTintNear: 7, sunTintAll: 8, sunDepth: 9 };
/** Distance before a pane within which a point counts as behind it, texels: a map does not tell where in its texel a pane meets a surface, and unfiltered light on
 * the inner side is brighter than filtered light on the outer side is dark. */
const PANE_TEXELS = 2;
/** Largest number of suns: their depths take one unit each. */
export const MAX_SUNS = 4;

/** Declarations and functions for `count` suns; for none a function that returns zero. */
export const sunCode = (count) => (count === 0 ? 'vec3 sunlight(vec3 p, vec3 n, float turn) { return vec3(0.0); }' : `
const int SUNS = ${count};
const int SEARCH = 16;
uniform highp sampler2DArray sunOpaque, sunNear, sunFar;
uniform mediump sampler2DArray sunTintNear, sunTintAll;
${Array.from({ length: count }, (_, k) => `uniform highp sampler3D sunDepth${k};`).join('\n')}
uniform mat4 sunSpace[SUNS];
// One over width, height and depth of the map, 1/m; tangent of the angular radius.
uniform vec4 sunScale[SUNS];
uniform vec3 sunLight[SUNS];
uniform vec3 sunBoxLow, sunBoxHigh;
uniform int sunSamples;
uniform bool sunPanes;

vec3 sunAxis(int k, int row) { return vec3(sunSpace[k][0][row], sunSpace[k][1][row], sunSpace[k][2][row]); }
vec3 sunNodes(int k) {
${Array.from({ length: count }, (_, k) => `  if (k == ${k}) return vec3(textureSize(sunDepth${k}, 0));`).join('\n')}
  return vec3(1.0);
}
vec3 sunDepthAt(int k, vec3 at) {
${Array.from({ length: count }, (_, k) => `  if (k == ${k}) return texture(sunDepth${k}, at).rgb;`).join('\n')}
  return vec3(0.0);
}
// exp(−D) at a point; outside of the medium from where its light enters it.
vec3 sunPassed(int k, vec3 p) {
  vec3 towards = -sunAxis(k, 2);
  towards = mix(towards, vec3(1e-7), lessThan(abs(towards), vec3(1e-7)));
  vec3 one = (sunBoxLow - p) / towards, two = (sunBoxHigh - p) / towards;
  vec3 lo = min(one, two), hi = max(one, two);
  float enter = max(max(lo.x, max(lo.y, lo.z)), 0.0), leave = min(hi.x, min(hi.y, hi.z));
  if (enter >= leave) return vec3(1.0);
  vec3 at = clamp((p + enter * towards - sunBoxLow) / (sunBoxHigh - sunBoxLow), 0.0, 1.0).zyx;
  vec3 nodes = sunNodes(k);
  return exp(-sunDepthAt(k, (at * (nodes - 1.0) + 0.5) / nodes));
}
ivec3 sunTexel(int k, vec2 q) {
  ivec2 size = textureSize(sunOpaque, 0).xy;
  return ivec3(clamp(ivec2(floor(q * sunScale[k].xy * vec2(size))), ivec2(0), size - 1), k);
}
float sunBias(int k) { return 2e-5 / sunScale[k].z; }
// Width and height of a texel, m.
vec2 sunTexelSize(int k) { return 1.0 / (vec2(textureSize(sunOpaque, 0).xy) * sunScale[k].xy); }
// Distance, m, of the surface in the map before the receiver's plane at an offset.
float sunGap(int k, vec3 q, vec2 slope, vec2 offset) {
  ivec3 at = sunTexel(k, q.xy + offset);
  vec2 texel = sunTexelSize(k);
  vec2 centre = (vec2(at.xy) + 0.5) * texel - q.xy;
  // Rasterisers round vertices to a fraction of a texel, a sixteenth at worst.
  float margin = 1e-4 * length(centre) * (1.0 + dot(slope, slope)) + 0.13 * dot(abs(slope), texel);
  return q.z + dot(slope, centre) - margin - texelFetch(sunOpaque, at, 0).r / sunScale[k].z;
}
// The texel of the panes at an offset. Where a wall before a pane ends in the texel, the map lacks the pane: a texel beside it has it.
ivec3 sunPaneTexel(int k, vec2 q) {
  ivec3 at = sunTexel(k, q);
  if (texelFetch(sunFar, at, 0).r > 0.0) return at;
  ivec3 last = ivec3(textureSize(sunFar, 0).xy - 1, k);
  for (int i = 0; i < 9; i++) {
    ivec3 beside = clamp(at + ivec3(i % 3 - 1, i / 3 - 1, 0), ivec3(0, 0, k), last);
    if (texelFetch(sunFar, beside, 0).r > 0.0) return beside;
  }
  return at;
}
// Depth in the map down to which panes lie before a point.
float sunPaneDepth(int k, vec3 q) {
  vec2 texel = sunTexelSize(k);
  return (q.z + sunBias(k) + float(${PANE_TEXELS}) * max(texel.x, texel.y)) * sunScale[k].z;
}
// Transmittance of the panes between the sun and a depth of the map; the maps hold its square root.
vec3 sunTint(int k, vec3 q, vec2 offset) {
  if (!sunPanes) return vec3(1.0);
  ivec3 at = sunPaneTexel(k, q.xy + offset);
  float z = sunPaneDepth(k, q);
  vec3 root = vec3(1.0);
  if (z >= texelFetch(sunFar, at, 0).r) root = texelFetch(sunTintAll, at, 0).rgb;
  else if (z >= texelFetch(sunNear, at, 0).r) root = texelFetch(sunTintNear, at, 0).rgb;
  return root * root;
}
// Distance, m, of the last pane before a depth of the map, at least that of the bias; 0 without.
float sunPaneGap(int k, vec3 q, vec2 offset) {
  if (!sunPanes) return 0.0;
  ivec3 at = sunPaneTexel(k, q.xy + offset);
  float z = sunPaneDepth(k, q), far = texelFetch(sunFar, at, 0).r;
  float pane = z >= far ? far : texelFetch(sunNear, at, 0).r;
  return pane > 0.0 && z >= pane ? max(q.z - pane / sunScale[k].z, sunBias(k)) : 0.0;
}
vec2 sunDisc(float radius, int i, float turn) {
  float angle = 2.39996323 * float(i) + 6.28318531 * turn;
  return radius * vec2(cos(angle), sin(angle));
}
// True where a ray is blocked near the distance at which it passes the offset.
bool sunBlocked(int k, vec3 q, vec2 slope, vec2 ray, float from, float texel) {
  float d = sunGap(k, q, slope, ray * from);
  if (d <= sunBias(k)) return false;
  return length(ray) * abs(d - from) < texel || sunGap(k, q, slope, ray * d) > sunBias(k);
}
// True where a surface lies a few texels before the point in its texel or one beside it: at the seam of two walls a texel
// may hold neither or the wrong one. Where it holds what lies behind the point, any surface before it counts.
bool sunTouched(int k, vec3 q, vec2 slope, vec2 texel) {
  float width = dot(texel, 1.0 + abs(slope));
  float reach = sunGap(k, q, slope, vec2(0.0)) < -0.5 * width ? 1e30 : 4.0 * width;
  for (int i = 0; i < 9; i++) {
    float d = sunGap(k, q, slope, texel * vec2(i % 3 - 1, i / 3 - 1));
    if (d > sunBias(k) && d < reach) return true;
  }
  return false;
}
// Mean transmittance of panes, zero for blocked rays, at a surface point.
vec3 sunSeen(int k, vec3 p, vec3 n, float turn) {
  vec3 q = (sunSpace[k] * vec4(p, 1.0)).xyz;
  vec2 slope = vec2(dot(n, sunAxis(k, 0)), dot(n, sunAxis(k, 1))) / -dot(n, sunAxis(k, 2));
  vec2 texels = sunTexelSize(k);
  if (sunTouched(k, q, slope, texels)) return vec3(0.0);
  float texel = max(texels.x, texels.y), tangent = sunScale[k].w;
  float near = 1e30, far = 0.0, glass = 0.0, panes = 0.0;
  int blocked = 0;
  for (int i = 0; i < SEARCH; i++) {
    // Offsets are denser in the middle, where near surfaces block the narrow end of the cone.
    float x = float(i) / float(SEARCH - 1), offset = x * x * tangent * q.z;
    vec2 o = sunDisc(offset, i, turn);
    float d = sunGap(k, q, slope, o);
    if (d > sunBias(k) && offset <= tangent * d + texel) {
      near = min(near, d);
      far = max(far, d);
      if (offset <= tangent * d) blocked++;
    }
    float g = sunPaneGap(k, q, o);
    if (g > 0.0 && offset <= tangent * g + texel) {
      glass += g;
      panes += 1.0;
    }
  }
  if (blocked == SEARCH) return vec3(0.0);
  // Panes that were not met are as far as the frames beside them.
  glass = panes > 0.0 ? glass / panes : far;
  if (far == 0.0 && panes == 0.0) return vec3(1.0);
  // At least the filter of a texel.
  float width = max(tangent, 0.7 * texel / max(max(far, glass), texel));
  vec3 sum = vec3(0.0);
  for (int i = 0; i < sunSamples; i++) {
    vec2 ray = sunDisc(width * sqrt((float(i) + 0.5) / float(sunSamples)), i, turn);
    if (far > 0.0 && (sunBlocked(k, q, slope, ray, far, texel) || sunBlocked(k, q, slope, ray, near, texel))) continue;
    if (panes > 0.0 && sunBlocked(k, q, slope, ray, glass, texel)) continue;
    sum += sunTint(k, q, ray * glass);
  }
  return sum / float(sunSamples);
}
// H_dir of all suns at a surface point.
vec3 sunlight(vec3 p, vec3 n, float turn) {
  vec3 sum = vec3(0.0);
  for (int k = 0; k < SUNS; k++) {
    float cosine = -dot(n, sunAxis(k, 2));
    if (cosine <= 1e-4 || sunLight[k] == vec3(0.0)) continue;
    vec3 seen = sunSeen(k, p, n, turn);
    if (seen != vec3(0.0)) sum += cosine * seen * sunPassed(k, p) * sunLight[k];
  }
  return sum;
}
// G_dir of all suns at a point of the medium, by one ray to each sun.
vec3 sunFluence(vec3 p, float turn, float radius) {
  vec3 sum = vec3(0.0);
  for (int k = 0; k < SUNS; k++) {
    if (sunLight[k] == vec3(0.0)) continue;
    vec3 q = (sunSpace[k] * vec4(p, 1.0)).xyz;
    vec2 ray = sunDisc(sunScale[k].w * sqrt(radius), 0, turn);
    float d = sunGap(k, q, vec2(0.0), vec2(0.0));
    if (d <= sunBias(k)) d = sunPaneGap(k, q, vec2(0.0));
    vec2 offset = ray * d;
    if (sunGap(k, q, vec2(0.0), offset) > sunBias(k)) continue;
    sum += sunTint(k, q, offset) * sunPassed(k, p) * sunLight[k];
  }
  return sum;
}`);

const HEAD = `#version 300 es
precision highp float;
precision highp int;
`;

/** Depth of surfaces and panes as seen from a sun. */
export const SUN_DEPTH = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
uniform mat4 toMap;
uniform float behind;
void main() {
  gl_Position = toMap * vec4(position, 1.0);
  gl_Position.z += behind;
}`,
  fragment: `${HEAD}
void main() {}`,
};

/** Square root of the transmittance of panes before the first surface. */
export const SUN_TINT = {
  vertex: `${HEAD}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint pane;
uniform mat4 toMap;
flat out vec3 vNormal;
flat out int vPane;
void main() {
  vNormal = normal;
  vPane = int(pane);
  gl_Position = toMap * vec4(position, 1.0);
}`,
  fragment: `${HEAD}
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform highp sampler2DArray sunOpaque;
uniform vec3 towards;
uniform int layer;
out vec4 colour;
void main() {
  if (gl_FragCoord.z > texelFetch(sunOpaque, ivec3(gl_FragCoord.xy, layer), 0).r + 2e-5) discard;
  float cosine = max(abs(dot(towards, vNormal)), 1e-4);
  colour = vec4(exp(-0.5 * texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine), 1.0);
}`,
};
