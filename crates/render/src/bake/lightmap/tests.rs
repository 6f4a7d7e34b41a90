//! Lightmaps against the light of their points and the powers of the zones.

use super::*;
use crate::test_scenes::{quad, solution, sun, surface, walls};
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{Bands, Facet, Light, NoProgress, Plate, SceneParts};
use zonal_transport::lights::{LightSampler, Receiver};

/// A box of 2 × 2 × 1.5 m with a board on one side of which the sun shines, open above.
fn lit_box() -> SceneParts {
    let mut facets = walls(vec3(-1.0, -1.0, 0.0), vec3(1.0, 1.0, 1.5));
    facets.remove(1);
    facets.push(quad(1, vec3(-0.5, -0.4, 0.8), vec3(0.7, 0.1, 0.0), vec3(0.0, 0.6, 0.1)));
    SceneParts {
        surfaces: vec![surface("wall", 0.5, 0.0), surface("board", 0.5, 0.0)],
        facets,
        lights: vec![sun(vec3(0.2, 0.3, -0.9), 0.0)],
        ..SceneParts::default()
    }
}

fn with_texel(texel: f64) -> LightmapOptions {
    LightmapOptions { texel: Some(texel), ..LightmapOptions::default() }
}

fn baked(s: &Solution, texel: f64) -> Lightmap {
    bake_lightmap(s, &with_texel(texel), &NoProgress).unwrap()
}

/// The bilinearly filtered value at coordinates 0 to 1.
fn filtered(map: &Lightmap, uv: [f64; 2]) -> [f64; 3] {
    let [x, y] = [uv[0] * map.width as f64 - 0.5, uv[1] * map.height as f64 - 0.5];
    let (i, j) = (x.floor(), y.floor());
    let texel = |di: usize, dj: usize| {
        let (c, r) = ((i as usize + di).min(map.width - 1), (j as usize + dj).min(map.height - 1));
        map.irradiance[r * map.width + c]
    };
    let (a, b) = (x - i, y - j);
    [0, 1, 2].map(|k| {
        let v = |di, dj| f64::from(texel(di, dj)[k]);
        (1.0 - b) * ((1.0 - a) * v(0, 0) + a * v(1, 0)) + b * ((1.0 - a) * v(0, 1) + a * v(1, 1))
    })
}

/// Points of a triangle: position, normal and coordinates in the lightmap, with its area, m².
fn points(map: &Lightmap, triangle: usize, count: usize) -> (Vec<(Vec3, Vec3, [f64; 2])>, f64) {
    let m = &map.mesh;
    let t = m.triangles[triangle].map(|i| i as usize);
    let at = |i: usize| Vec3::from_array(m.positions[i].map(f64::from));
    let plate = Plate::triangle(at(t[0]), at(t[1]), at(t[2]));
    let normal = Vec3::from_array(m.normals[t[0]].map(f64::from));
    assert!((plate.normal() - normal).length() < 1e-5);
    let one = |k: usize| {
        let [u, v] = plate.warp(low_discrepancy::r2(k, [0.3, 0.7]));
        let w = [1.0 - u - v, u, v];
        let uv = [0, 1].map(|c| (0..3).map(|n| w[n] * f64::from(m.lightmap_uvs[t[n]][c])).sum());
        (plate.at(u, v), normal, uv)
    };
    ((0..count).map(one).collect(), plate.area())
}

#[test]
fn texels_have_the_light_of_their_points() {
    let h = |_: Vec3, n: Vec3| 1.0 + 0.1 * n.z;
    let s = solution(lit_box(), h, |_| 0.0);
    let map = baked(&s, 0.02);
    let transport = Transport::new(&s.scene);
    let lamp = LightSampler::new(&s.scene, &s.scene.lights()[0]);
    let (mut all, mut off, mut lit) = (0, 0, 0);
    for triangle in 0..map.mesh.triangles.len() {
        for (p, n, uv) in points(&map, triangle, 400).0 {
            // Positions are in single precision.
            let direct = lamp.gather(&transport, p + n * 1e-6, Receiver::Surface(n), 1, 0).to_rgb();
            let found = filtered(&map, uv);
            let expected = direct.map(|d| d + h(p, n));
            let error = (0..3).fold(0.0, |m: f64, k| m.max((found[k] / expected[k] - 1.0).abs()));
            all += 1;
            off += usize::from(error > 0.01);
            lit += usize::from(direct[0] > 0.0);
        }
    }
    // Texels that a shadow edge divides differ.
    assert!(all == 400 * 24 && lit > all / 3 && off < all / 150, "{off} of {all} differ, {lit} lit");
}

// Guards (pictures): the charts of a lightmap do not mix.
#[test]
fn filtering_mixes_no_charts() {
    // Facets of many sizes, each with an irradiance of its own by its normal.
    let h = |_: Vec3, n: Vec3| 2.0 + n.x + 0.3 * n.y + 0.1 * n.z;
    let mut parts = lit_box();
    parts.lights.clear();
    for k in 0..60usize {
        let at = |m: usize| {
            let [a, b] = low_discrepancy::r2(3 * k + m, [0.1, 0.5]);
            let c = low_discrepancy::hash_to_unit((3 * k + m) as u64);
            vec3(0.3 * (a - 0.5), 0.3 * (b - 0.5), 0.3 * c)
        };
        let away = vec3(3.0 + (k % 8) as f64, (k / 8) as f64, 0.0);
        let plate = Plate::triangle(away + at(0), away + at(1), away + at(2));
        parts.facets.push(Facet { surface: 1, plate, uv: [[0.0; 2]; 3] });
    }
    let s = solution(parts, h, |_| 0.0);
    for texel in [0.31, 0.07, 0.013] {
        let map = baked(&s, texel);
        assert_eq!(map.charts, 2 * (6 + 60));
        for triangle in 0..map.mesh.triangles.len() {
            for (_, n, uv) in points(&map, triangle, 50).0 {
                let (found, expected) = (filtered(&map, uv)[0], h(Vec3::ZERO, n));
                assert!((found / expected - 1.0).abs() < 1e-5, "{texel} {triangle}: {found} {expected}");
            }
        }
    }
}

#[test]
fn charts_neither_overlap_nor_leave_the_atlas() {
    let s = solution(lit_box(), |_, _| 1.0, |_| 0.0);
    let charts = charts::flat_charts(&s);
    for options in [with_texel(0.05), LightmapOptions { max_side: 256, ..LightmapOptions::default() }] {
        let atlas = packing::pack(&charts, &options).unwrap();
        let mut owner = vec![usize::MAX; atlas.width * atlas.height];
        for (k, place) in atlas.places.iter().enumerate() {
            for j in place.at[1]..place.at[1] + place.size[1] {
                for i in place.at[0]..place.at[0] + place.size[0] {
                    assert!(i < atlas.width && j < atlas.height && owner[j * atlas.width + i] == usize::MAX);
                    owner[j * atlas.width + i] = k;
                }
            }
        }
        let used = owner.iter().filter(|o| **o != usize::MAX).count();
        assert!(used * 10 > owner.len() * 7, "{used} of {} texels are used", owner.len());
    }
}

// Guards (pictures): a lightmap has the power of the zones.
#[test]
fn power_of_texels_is_that_of_the_zones() {
    let mut s = solution(lit_box(), |p, n| 1.0 + 0.3 * p.x + 0.1 * n.z, |_| 0.0);
    // Direct light of the zones as a solver has it: means over many points.
    let transport = Transport::new(&s.scene);
    let lamp = LightSampler::new(&s.scene, &s.scene.lights()[0]);
    let of = |p: &zonal_scene::Patch| {
        let at = |k: usize| {
            let [u, v] = p.plate.warp(low_discrepancy::r2(k, [0.0; 2]));
            lamp.gather(&transport, p.plate.at(u, v), Receiver::Surface(p.normal), 1, 0)
        };
        (0..256).map(at).sum::<Bands>() / 256.0
    };
    s.fields.direct = s.zones.patches.iter().map(of).collect();
    let power = |p: (usize, &zonal_scene::Patch)| (s.fields.incident[p.0] + s.fields.direct[p.0]) * p.1.area;
    let expected = s.zones.patches.iter().enumerate().map(power).sum::<Bands>().to_rgb();
    let mut errors = Vec::new();
    for texel in [0.08, 0.02] {
        let map = baked(&s, texel);
        let mut sum = [0.0; 3];
        for triangle in 0..map.mesh.triangles.len() {
            let (list, area) = points(&map, triangle, 4000);
            for (_, _, uv) in list {
                let value = filtered(&map, uv);
                (0..3).for_each(|k| sum[k] += value[k] * area / 4000.0);
            }
        }
        errors.push((0..3).fold(0.0, |m: f64, k| m.max((sum[k] / expected[k] - 1.0).abs())));
    }
    assert!(errors[0] < 0.01 && errors[1] < 0.003, "{errors:?}");
}

#[test]
fn coplanar_facets_are_one_chart_and_threads_do_not_matter() {
    // A square of two triangles beside a rectangle in the same plane, and one that is bent off it.
    let triangle = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| Facet {
        surface: 0,
        plate: Plate::triangle(Vec3::from_array(a), Vec3::from_array(b), Vec3::from_array(c)),
        uv: [[0.0; 2]; 3],
    };
    let facets = vec![
        triangle([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
        triangle([0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]),
        quad(0, vec3(1.0, 0.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)),
        quad(0, vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)),
    ];
    let mut one_sided = surface("wall", 0.5, 0.0);
    one_sided.sides = zonal_scene::Sides::Front;
    let lights = vec![Light::Sky {
        name: "sky".into(),
        radiance: Bands::ONE,
        distribution: zonal_scene::SkyDistribution::uniform(),
    }];
    let parts = SceneParts { surfaces: vec![one_sided], facets, lights, ..SceneParts::default() };
    let s = solution(parts, |_, _| 1.0, |_| 0.0);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| baked(&s, 0.1))
    };
    let map = run(1);
    assert_eq!(map, run(3));
    assert_eq!((map.charts, map.covered), (2, 30 * 10 + 10 * 10));
}

#[test]
fn an_atlas_that_is_too_small_is_refused_and_the_finest_texel_is_found() {
    let s = solution(lit_box(), |_, _| 1.0, |_| 0.0);
    let bake = |texel, max_side| {
        let options = LightmapOptions { texel, max_side, ..LightmapOptions::default() };
        bake_lightmap(&s, &options, &NoProgress)
    };
    for texel in [1e-4, 1e-300] {
        let error = bake(Some(texel), 512).unwrap_err();
        assert!(error.charts == 12 && error.max_side == 512 && error.texels > 512.0 * 512.0);
    }
    assert!(bake(None, 8).is_err());
    let map = bake(None, 256).unwrap();
    assert!(map.width <= 256 && map.height <= 256 && map.covered * 10 > 256 * 256 * 5, "{}", map.covered);
}

#[test]
fn edges_have_vertices_where_corners_of_others_touch_them() {
    // A wide rectangle below two halves, and a triangle that stands on it.
    let facets = vec![
        quad(0, Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)),
        quad(0, vec3(0.0, 1.0, 0.0), vec3(0.7, 0.0, 0.0), vec3(0.0, 1.0, 0.0)),
        quad(0, vec3(0.7, 1.0, 0.0), vec3(1.3, 0.0, 0.0), vec3(0.0, 1.0, 0.0)),
        Facet {
            surface: 0,
            plate: Plate::triangle(vec3(0.5, 0.0, 0.0), vec3(1.5, 0.0, 0.0), vec3(1.0, 0.0, 1.0)),
            uv: [[0.0; 2]; 3],
        },
    ];
    let parts = SceneParts { surfaces: vec![surface("wall", 0.5, 0.0)], facets, ..SceneParts::default() };
    let map = baked(&solution(parts, |_, _| 1.0, |_| 0.0), 0.1);
    let at = |i: u32| Vec3::from_array(map.mesh.positions[i as usize].map(f64::from));
    let mut area = 0.0;
    for t in &map.mesh.triangles {
        area += 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).length();
        for k in 0..3 {
            let (a, b) = (at(t[k]), at(t[(k + 1) % 3]));
            for p in &map.mesh.positions {
                let p = Vec3::from_array(p.map(f64::from));
                let between = (p - a).length() + (p - b).length() - (a - b).length() < 1e-9;
                assert!(
                    !between || (p - a).length() < 1e-6 || (p - b).length() < 1e-6,
                    "{p:?} in {a:?} {b:?}"
                );
            }
        }
    }
    assert!((area - 2.0 * (2.0 + 2.0 + 0.5)).abs() < 1e-5, "{area}");
}
