//! Light at the corners of patches and of pieces of panes, for files with values at points.
//!
//! At a corner x of a patch with the mean irradiance H̄ and radiosity B̄
//!
//! ```text
//!     H(x) = Σ_g H_g(x)        B(x) = B̄ + (ρ + τ)(H(x) − H̄),    on a surface with a texture E(x) + (ρ(x) + τ(x)) H(x)
//! ```
//!
//! with H_g(x) the light of a vertex of [`super::bake`]. Without a texture the first form is E + (ρ + τ) H(x), in thermal mode with the source of a zone of known
//! power. A corner that several patches share has a value for each: they differ at creases, at walls and where a value is limited to those nearby.

use super::baked::{BakeOptions, SunlightMode};
use super::group_fields::GroupField;
use super::lit_scene::LitScene;
use super::vertex_lighting::VertexLighting;
use crate::surface::patch_field::{TileField, TileTopology};
use crate::surface::tiles::pane_tiles;
use zonal_math::parallel;
use zonal_scene::{Bands, Plate, PlateKind, Progress, Solution};
use zonal_transport::Transport;
use zonal_transport::patch_locator::pane_plates;

/// Light at corners: those of each patch in turn, then those of each piece of a pane, in the order of [`Plate::corners`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerLight {
    /// Radiosity B, direct light included, W/m².
    pub radiosity: Vec<Bands>,
    /// Irradiance H of patches, direct light included; zero on panes, W/m².
    pub irradiance: Vec<Bands>,
}

/// Evaluates the light at all corners of a solution's patches and panes. The same bits for any number of threads. Cost: one evaluation a corner.
#[must_use]
pub fn light_at_corners(s: &Solution, progress: &dyn Progress) -> CornerLight {
    let transport = Transport::new(&s.scene);
    let lit = LitScene::of(&s.scene, SunlightMode::Baked);
    let shadow_rays = Transport::new(&lit.scene);
    let groups = GroupField::denoised_of_solution(s);
    let samples = BakeOptions::default().light_samples;
    let lighting = VertexLighting::new(s, &transport, &lit, &shadow_rays, &groups, samples);
    progress.begin("corners", s.zones.patches.len() as u64);
    let of_patch = |i: usize| {
        progress.advance(1);
        let at = |uv: &[f64; 2]| light_of_corner(&lighting, i, *uv);
        corner_parameters(&s.zones.patches[i].plate).iter().map(at).collect::<Vec<_>>()
    };
    let patches: Vec<Vec<(Bands, Bands)>> = parallel::collect(s.zones.patches.len(), of_patch);
    progress.end();
    let (mut radiosity, mut irradiance): (Vec<Bands>, Vec<Bands>) = patches.into_iter().flatten().unzip();
    radiosity.extend(pane_radiosities(s));
    irradiance.resize(radiosity.len(), Bands::ZERO);
    CornerLight { radiosity, irradiance }
}

/// B and H at a corner of a patch.
fn light_of_corner(lighting: &VertexLighting, i: usize, uv: [f64; 2]) -> (Bands, Bands) {
    let h = lighting.irradiance(i, uv);
    let s = lighting.solution;
    let (patch, f) = (&s.zones.patches[i], &s.fields);
    let surface = &s.scene.surfaces()[patch.surface];
    let has_texture = surface.reflectance_texture.is_some()
        || surface.emission_texture.is_some()
        || surface.transmission.is_some_and(|t| t.texture.is_some());
    if has_texture && s.scene.thermal().is_none() {
        let [u, v] = s.scene.facets()[patch.facet].plate.parameters(lighting.point(i, uv));
        let scattered =
            s.scene.reflectance_at(patch.facet, u, v) + s.scene.transmittance_at(patch.facet, u, v);
        // Patches of direct emitters have no emission.
        let emits = !s.scene.is_direct_emitter(patch.surface);
        let emission = if emits { s.scene.emission_at(patch.facet, u, v) } else { Bands::ZERO };
        return (emission + scattered * h, h);
    }
    let mean = s.zones.mixed(i, |k| f.incident[k] + f.direct_light(k));
    let scattered = patch.reflectance + s.zones.sheets.transmittance(i);
    (f.radiosity[i] + scattered * (h - mean), h)
}

/// B at the corners of the pieces of panes, interpolated between them.
fn pane_radiosities(s: &Solution) -> Vec<Bands> {
    let (_, _, of) = pane_plates(&s.scene, &s.zones);
    let topology = TileTopology::new(pane_tiles(s, &of), None);
    let field = TileField::new(s.fields.radiosity[s.zones.pane_offset()..].to_vec());
    let of_piece = |i: usize| {
        let at = |uv: &[f64; 2]| field.at(&topology, i, *uv);
        corner_parameters(&s.zones.panes[i].plate).iter().map(at).collect::<Vec<_>>()
    };
    let pieces: Vec<Vec<Bands>> = parallel::collect(s.zones.panes.len(), of_piece);
    pieces.into_iter().flatten().collect()
}

/// Parameters of the corners of a plate.
fn corner_parameters(plate: &Plate) -> &'static [[f64; 2]] {
    match plate.kind {
        PlateKind::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        PlateKind::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::bake;
    use crate::test_scenes::{furnace, quad, solution, sun, surface};
    use std::collections::HashMap;
    use zonal_math::vec3;
    use zonal_scene::{NoProgress, SceneParts};

    #[test]
    fn furnace_has_one_radiosity_at_all_corners() {
        let light = light_at_corners(&solution(furnace(), |_, _| 1.0, |_| 1.0), &NoProgress);
        assert!(light.radiosity.iter().all(|b| (b.first() - 1.0).abs() < 1e-6));
        assert!(light.irradiance.iter().all(|h| (h.first() - 1.0).abs() < 1e-6));
    }

    #[test]
    fn corners_have_the_light_of_baked_vertices() {
        let parts = SceneParts {
            surfaces: vec![surface("floor", 0.4, 2.0), surface("board", 0.0, 0.0)],
            facets: vec![
                quad(0, vec3(-1.0, -1.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0)),
                quad(1, vec3(-0.2, -0.3, 0.5), vec3(0.7, 0.0, 0.0), vec3(0.0, 0.6, 0.0)),
            ],
            lights: vec![sun(vec3(0.2, 0.1, -1.0), 0.0)],
            ..SceneParts::default()
        };
        let mut s = solution(parts, |p, n| 1.0 + 0.2 * p.x + 0.1 * n.z, |_| 0.0);
        // The zones' own direct light, by which the radiosity of a patch is known.
        for (i, p) in s.zones.patches.iter().enumerate() {
            let direct = Bands::splat(0.1 * i as f64);
            (s.fields.direct[i], s.fields.radiosity[i]) =
                (direct, p.emission + p.reflectance * (s.fields.incident[i] + direct));
        }
        let light = light_at_corners(&s, &NoProgress);
        let baked = bake(&s, &BakeOptions::default(), &NoProgress).surfaces;
        // Vertices of the bake by position and side.
        let key = |p: [f32; 3], n: [f32; 3]| [p, n].map(|v| v.map(|x| (x * 1e4).round() as i64));
        let mut known: HashMap<_, Vec<usize>> = HashMap::new();
        for i in 0..baked.positions.len() {
            known.entry(key(baked.positions[i], baked.normals[i])).or_default().push(i);
        }
        let single = |v: zonal_math::Vec3| v.array().map(|x| x as f32);
        let (mut at, mut shadowed) = (0, 0);
        for p in &s.zones.patches {
            let (corners, n) = p.plate.corners();
            for c in &corners[..n] {
                let (h, b) = (light.irradiance[at].first(), light.radiosity[at].first());
                let near = |i: &usize| (f64::from(baked.irradiance[0][*i][0]) - h).abs() < 0.03 * h;
                assert!(known[&key(single(*c), single(p.normal))].iter().any(near), "{c:?} {h}");
                assert!((b - p.emission.first() - p.reflectance.first() * h).abs() < 1e-6);
                shadowed += usize::from(p.normal.z > 0.0 && h < 1.5);
                at += 1;
            }
        }
        assert_eq!((at, light.radiosity.len()), (light.irradiance.len(), at));
        assert!(shadowed > 4 && shadowed < at / 4);
    }
}
