// Relighting: light groups are summed in the browser, H = Σ f_g H_g, with factors f_g. All results are linear in the factors.

import { VALUES } from './half_float.js';

/** Adds `factor` times an array of half floats to `out`. */
function addHalves(out, halves, factor) {
  for (let i = 0; i < out.length; i++) out[i] += factor * VALUES[halves[i]];
}

/** Σ_g f_g X_g over the half-float arrays named stem + g for each of the stems, each times its group's scale of that name; missing arrays count as zero. */
export function sumGroups(scene, stems, factors, length) {
  const out = new Float32Array(length);
  scene.groups.forEach((group, g) => {
    for (const stem of stems) {
      const halves = scene.arrays[stem + g];
      if (halves && factors[g]) addHalves(out, halves, factors[g] * group.scales[stem]);
    }
  });
  return out;
}

/** Emitted flux of each surface, W/m², scaled by the factor of its group. */
export function surfaceEmissions(scene, factors) {
  return scene.surfaces.map((s) => s.emission.map((e) => e * (s.group === null ? 1 : factors[s.group])));
}

/** Radiance of the surroundings, W/(m² sr). */
export function background(scene, factors) {
  return [0, 1, 2].map((b) => scene.groups.reduce((s, g, i) => s + factors[i] * g.background[b], 0));
}

/** The field `show` of a patch for a part of the light: total, direct or indirect. The radiosity of a part is ρ times its irradiance, without emission. */
export function partOf(fields, show, part) {
  if (part === 'total' || show === 'error') return fields[show];
  return show === 'radiosity' ? fields[part].map((x, b) => x * fields.reflectance[b]) : fields[part];
}

/** Fields of the solution on a patch with the groups scaled, W/m². */
export function patchFields(scene, zone, factors) {
  const { arrays, groups, surfaces } = scene;
  const three = (name) => {
    const a = arrays[name];
    return a ? [0, 1, 2].map((b) => a[3 * zone + b]) : [0, 0, 0];
  };
  const total = (stem) => groups.reduce((s, _, g) => {
    const v = three(stem + g);
    return s.map((x, b) => x + factors[g] * v[b]);
  }, [0, 0, 0]);
  const indirect = total('zoneIndirect');
  const direct = total('zoneDirect');
  const rho = three('zoneReflectance');
  const s = surfaces[arrays.zoneSurface[zone]];
  const f = s.group === null ? 1 : factors[s.group];
  const emission = three('zoneEmission').map((e) => e * f);
  return {
    indirect,
    direct,
    irradiance: indirect.map((x, b) => x + direct[b]),
    radiosity: rho.map((r, b) => emission[b] + r * (indirect[b] + direct[b])),
    reflectance: rho,
    error: three('zoneError'),
  };
}
