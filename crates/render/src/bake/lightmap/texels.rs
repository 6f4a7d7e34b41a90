//! Light of the texels of charts.
//!
//! A texel whose centre lies on a facet has the light of that point. One beside the facets, up to the margin, has the light of the nearest point of a facet. All
//! others of a chart's rectangle take the mean of those neighbours that are known, from the chart outwards.

use super::charts::FlatChart;
use super::lightmap_data::CHART_MARGIN;
use super::packing::{AtlasRectangle, PackedAtlas};
use crate::bake::vertex_lighting::VertexLighting;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Bands, Plate, PlateKind, Progress};
use zonal_transport::patch_locator::{PatchLocator, clamped_parameters, facet_side_locator};

/// Parameters by which a point may lie outside of a facet and still count as on it.
const PARAMETER_TOLERANCE: f64 = 1e-9;

/// The point of a facet at which a texel is evaluated.
#[derive(Clone, Copy)]
struct TexelSource {
    side: usize,
    /// Parameters of the facet.
    uv: [f64; 2],
    /// Squared distance from the centre of the texel, m²; zero on the facet.
    distance2: f64,
}

/// The irradiance of all texels of an atlas, and the number of those whose centre lies on a facet.
pub(super) fn light_texels(
    lighting: &VertexLighting,
    charts: &[FlatChart],
    atlas: &PackedAtlas,
    progress: &dyn Progress,
) -> (Vec<[f32; 3]>, usize) {
    let locator = facet_side_locator(&lighting.solution.scene, &lighting.solution.zones);
    progress.begin("lightmap", charts.len() as u64);
    let one = |(chart, place): (&FlatChart, &AtlasRectangle)| {
        let sources = texel_sources(lighting, chart, place, atlas.texel);
        let covered = sources.iter().flatten().filter(|s| s.distance2 == 0.0).count();
        let light = |s: &Option<TexelSource>| s.and_then(|s| light_at(lighting, &locator, s));
        let mut values: Vec<Option<Bands>> = parallel::map(&sources, light);
        dilate(&mut values, place.size);
        progress.advance(1);
        let single = |v: Option<Bands>| v.unwrap_or(Bands::ZERO).to_rgb().map(|x| x as f32);
        (values.into_iter().map(single).collect(), covered)
    };
    let charts_light: Vec<(Vec<[f32; 3]>, usize)> = charts.par_iter().zip(&atlas.places).map(one).collect();
    progress.end();
    let mut out = vec![[0.0; 3]; atlas.width * atlas.height];
    for ((values, _), place) in charts_light.iter().zip(&atlas.places) {
        for (k, value) in values.iter().enumerate() {
            let (i, j) = (place.at[0] + k % place.size[0], place.at[1] + k / place.size[0]);
            out[j * atlas.width + i] = *value;
        }
    }
    (out, charts_light.iter().map(|c| c.1).sum())
}

/// The source of each texel of a chart's rectangle, row by row; `None` farther from the facets than the margin.
fn texel_sources(
    lighting: &VertexLighting,
    chart: &FlatChart,
    place: &AtlasRectangle,
    texel: f64,
) -> Vec<Option<TexelSource>> {
    let [columns, rows] = place.size;
    let mut out: Vec<Option<TexelSource>> = vec![None; columns * rows];
    for &side in &chart.sides {
        let plate = &lighting.solution.scene.facets()[side / 2].plate;
        let (corners, n) = plate.corners();
        let at: Vec<[f64; 2]> = corners[..n].iter().map(|p| place.texels(texel, chart.project(*p))).collect();
        // The texels whose centres are no farther than the margin.
        let margin = CHART_MARGIN as f64;
        let range = |k: usize, size: usize| {
            let (lo, hi) = at.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[k]), b.max(p[k])));
            let first = (lo - margin - 0.5).floor().max(0.0) as usize;
            first..((hi + margin + 0.5).ceil().max(0.0) as usize).min(size)
        };
        for j in range(1, rows) {
            for i in range(0, columns) {
                let p = chart.point(place.centre(texel, [i, j]));
                let source = match on_plate(plate, plate.parameters(p)) {
                    Some(uv) => TexelSource { side, uv, distance2: 0.0 },
                    None => {
                        let uv = nearest_parameters(plate, chart, p);
                        let distance2 = (plate.at(uv[0], uv[1]) - p).length2().max(f64::MIN_POSITIVE);
                        TexelSource { side, uv, distance2 }
                    }
                };
                let known = &mut out[j * columns + i];
                let near = source.distance2 <= (margin * texel).powi(2);
                if near && known.is_none_or(|k| source.distance2 < k.distance2) {
                    *known = Some(source);
                }
            }
        }
    }
    out
}

/// Parameters of a point on a plate, clamped to it; `None` outside.
fn on_plate(plate: &Plate, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
    let inside = |x: f64| (-PARAMETER_TOLERANCE..=1.0 + PARAMETER_TOLERANCE).contains(&x);
    let is_on = inside(u) && inside(v) && (plate.kind == PlateKind::Parallelogram || inside(u + v));
    is_on.then(|| [u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)])
}

/// Parameters of the point of a plate's border that is nearest to a point outside.
fn nearest_parameters(plate: &Plate, chart: &FlatChart, p: Vec3) -> [f64; 2] {
    let (corners, n) = plate.corners();
    let on_edge = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % n]);
        let t = (p - a).dot(b - a) / (b - a).length2().max(f64::MIN_POSITIVE);
        a + (b - a) * t.clamp(0.0, 1.0)
    };
    let [x, y] = chart.project(p);
    let distance2 = |q: &Vec3| {
        let [u, v] = chart.project(*q);
        (u - x).powi(2) + (v - y).powi(2)
    };
    let nearest = (0..n).map(on_edge).reduce(|a, b| if distance2(&b) < distance2(&a) { b } else { a });
    clamped_parameters(plate, nearest.unwrap_or(p))
}

/// The irradiance at a source; `None` on a part of a facet without patches.
fn light_at(lighting: &VertexLighting, locator: &PatchLocator, source: TexelSource) -> Option<Bands> {
    let s = lighting.solution;
    let patch = locator.locate(source.side, source.uv)? as usize;
    let plate = &s.scene.facets()[source.side / 2].plate;
    let uv = clamped_parameters(&s.zones.patches[patch].plate, plate.at(source.uv[0], source.uv[1]));
    Some(lighting.irradiance(patch, uv))
}

/// Gives every texel without a value the mean of its known neighbours of the eight, ring by ring.
fn dilate(values: &mut [Option<Bands>], [columns, rows]: [usize; 2]) {
    let around = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        let across =
            move |y: usize| (i.saturating_sub(1)..(i + 2).min(columns)).map(move |x| y * columns + x);
        (j.saturating_sub(1)..(j + 2).min(rows)).flat_map(across)
    };
    let mut ring: Vec<usize> = (0..values.len())
        .filter(|k| values[*k].is_none() && around(*k).any(|m| values[m].is_some()))
        .collect();
    while !ring.is_empty() {
        let mean = |k: &usize| {
            let known = || around(*k).filter_map(|m| values[m]);
            known().sum::<Bands>() / known().count() as f64
        };
        let means: Vec<Bands> = ring.iter().map(mean).collect();
        ring.iter().zip(means).for_each(|(k, mean)| values[*k] = Some(mean));
        ring = ring.iter().flat_map(|k| around(*k)).filter(|m| values[*m].is_none()).collect();
        ring.sort_unstable();
        ring.dedup();
    }
}
