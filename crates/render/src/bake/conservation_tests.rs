//! Baked light against the solution: powers, groups, coverage, shadow edges, threads.

use super::*;
use crate::test_scenes::{furnace, medium, quad, solution, surface, walls};
use std::sync::LazyLock;
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    Band, Bands, Facet, Light, LightGroup, LightGroupKind, NoProgress, Pane, Plate, SceneParts, ZoneValues,
};
use zonal_transport::build_zones;

fn baked(s: &Solution, options: &BakeOptions) -> BakedSolution {
    bake(s, options, &NoProgress)
}

/// Areas of the triangles, m², in the order of the mesh.
fn areas(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f64> {
    let at = |i: u32| Vec3::from_array(positions[i as usize].map(f64::from));
    triangles.iter().map(|t| 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).length()).collect()
}

/// ∫ x dA a patch zone, x linear on triangles.
fn per_zone(mesh: &SurfaceMesh, values: &[[f32; 3]], patches: usize) -> Vec<f64> {
    let mut out = vec![0.0; patches];
    for ((t, a), z) in mesh.triangles.iter().zip(areas(&mesh.positions, &mesh.triangles)).zip(&mesh.zones) {
        out[*z as usize] += a / 3.0 * t.iter().map(|i| values[*i as usize][0] as f64).sum::<f64>();
    }
    out
}

fn room() -> Solution {
    static ROOM: LazyLock<Solution> = LazyLock::new(furnished);
    ROOM.clone()
}

/// A room under a sun and a lamp, with a board that casts shadows and a pane.
fn furnished_parts() -> SceneParts {
    let (lo, hi) = (vec3(-1.0, -1.0, 0.0), vec3(1.0, 1.0, 2.0));
    let mut facets = walls(lo, hi);
    facets.remove(1); // open above
    facets.push(quad(1, vec3(-0.4, -0.3, 1.0), vec3(0.7, 0.1, 0.0), vec3(0.0, 0.5, 0.0)));
    let lamp = Plate::triangle(vec3(0.6, 0.6, 1.7), vec3(0.6, 0.7, 1.7), vec3(0.7, 0.6, 1.7));
    facets.push(Facet { surface: 2, plate: lamp, uv: [[0.0; 2]; 3] });
    SceneParts {
        surfaces: vec![surface("wall", 0.4, 0.0), surface("board", 0.2, 0.0), surface("lamp", 0.0, 50.0)],
        facets,
        lights: vec![
            Light::Sun {
                name: "sun".into(),
                direction: vec3(0.2, 0.3, -0.9).normalized(),
                irradiance: Bands::from_rgb([4.0, 2.0, 1.0]),
                angular_diameter: 0.0,
            },
            Light::Emitter { surface: 2, name: None },
        ],
        voxel_grid: Some(medium(lo, hi, [4, 4, 4], 0.3, 0.5)),
        panes: vec![Pane {
            name: "pane".into(),
            plates: vec![Plate::triangle(
                vec3(-0.9, -0.9, 1.8),
                vec3(-0.5, -0.9, 1.8),
                vec3(-0.9, -0.5, 1.8),
            )],
            thickness: 0.01,
            extinction: Bands::from_rgb([20.0, 5.0, 1.0]),
            albedo: Bands::splat(0.5),
            emission: Bands::ZERO,
        }],
        ..SceneParts::default()
    }
}

/// H_dir of each zone from many of its points, as a solver would compute it: one list a light.
fn direct_irradiances(s: &Solution) -> Vec<Vec<Bands>> {
    let transport = Transport::new(&s.scene);
    let zones = build_zones(&s.scene, &transport).unwrap();
    let of = |light: &Light| {
        let lamp = zonal_transport::lights::LightSampler::new(&s.scene, light);
        let mut list = vec![Bands::ZERO; zones.len()];
        for (x, p) in list.iter_mut().zip(&zones.patches) {
            for k in 0..128 {
                let [u, v] = p.plate.warp(zonal_math::low_discrepancy::r2(k, [0.0; 2]));
                let receiver = zonal_transport::lights::Receiver::Surface(p.normal);
                let h = lamp.gather(&transport, p.plate.at(u, v), receiver, 4, k as u64);
                *x += h / 128.0;
            }
        }
        list
    };
    s.scene.lights().iter().map(of).collect()
}

/// The solution of the furnished room in the groups `sun`, `lamp` and `surroundings`.
fn furnished() -> Solution {
    let mut s = solution(furnished_parts(), |p, n| 1.0 + 0.3 * p.x + 0.1 * n.z, |p| 0.5 + 0.1 * p.z);
    let direct = direct_irradiances(&s);
    let n = s.zones.len();
    let part = |f: f64| ZoneValues::Double(s.fields.incident.iter().map(|x| *x * f).collect());
    let group = |name: &str, kind, incident, direct: Option<&Vec<Bands>>| LightGroup {
        name: name.into(),
        kind,
        incident,
        direct: direct.map_or(ZoneValues::default(), |d| ZoneValues::Double(d.clone())),
        ..LightGroup::default()
    };
    s.groups = vec![
        group("sun", LightGroupKind::Light(0), part(0.5), Some(&direct[0])),
        group("lamp", LightGroupKind::Light(1), part(0.3), Some(&direct[1])),
        group("surroundings", LightGroupKind::Surroundings, part(0.2), None),
    ];
    s.fields.direct = (0..n).map(|i| direct[0][i] + direct[1][i]).collect();
    s.fields.radiosity = (0..n)
        .map(|i| {
            let (e, (rho, _)) = (s.zones.emission(i), s.zones.response(i));
            e + rho * (s.fields.incident[i] + s.fields.direct_light(i))
        })
        .collect();
    s
}

#[test]
fn baked_furnace_has_one_radiance() {
    let s = solution(furnace(), |_, _| 1.0, |_| 1.0);
    let b = baked(&s, &BakeOptions::default());
    assert_eq!(b.groups, ["all"]);
    assert_eq!(b.emission_groups, [Some(0)]);
    for (h, e) in b.surfaces.irradiance[0].iter().flatten().zip(b.surfaces.emission.iter().flatten()) {
        assert!((*e + 0.4 * *h - 1.0).abs() < 1e-6, "{e} {h}");
    }
    // The light is uniform: no patch is split, and patches of a facet share their corners.
    assert!(b.surfaces.triangles.len() <= 2 * s.zones.patches.len());
    assert!(b.surfaces.positions.len() < 2 * s.zones.patches.len());
    let m = b.medium.unwrap();
    let volume: f64 = s.zones.voxels.iter().map(|v| v.volume).sum();
    assert!((m.volume.iter().map(|v| *v as f64).sum::<f64>() / volume - 1.0).abs() < 1e-6);
    for (v, g) in m.volume.iter().zip(&m.fluence[0]).filter(|(v, _)| **v > 0.0) {
        assert!((g[0] - 4.0).abs() < 1e-5, "{v} {g:?}");
    }
}

#[test]
fn triangles_cover_every_patch_once_and_face_its_side() {
    let s = room();
    let b = baked(&s, &BakeOptions { min_edge: Some(0.02), ..BakeOptions::default() });
    let mesh = &b.surfaces;
    let ones = vec![[1.0; 3]; mesh.positions.len()];
    for (a, p) in per_zone(mesh, &ones, s.zones.patches.len()).iter().zip(&s.zones.patches) {
        assert!((a / p.area - 1.0).abs() < 1e-5, "{a} {}", p.area);
    }
    for (t, z) in mesh.triangles.iter().zip(&mesh.zones) {
        let [x, y, w] = t.map(|i| Vec3::from_array(mesh.positions[i as usize].map(f64::from)));
        let n = s.zones.patches[*z as usize].normal;
        assert!((y - x).cross(w - x).normalized().dot(n) > 0.999);
    }
    assert!(mesh.triangles.len() > 8 * s.zones.patches.len(), "shadow edges are refined");
    let panes: f64 = areas(&b.panes.positions, &b.panes.triangles).iter().sum();
    assert!((panes / s.zones.panes.iter().map(|p| p.area).sum::<f64>() - 1.0).abs() < 1e-5);
    assert!((b.panes.depth[0][0] - 0.2).abs() < 1e-6);
}

#[test]
fn triangle_edges_match_between_neighbours() {
    let s = room();
    let mesh = baked(&s, &BakeOptions { min_edge: Some(0.03), ..BakeOptions::default() }).surfaces;
    // The walls have equal patches: every inner edge has an opposite edge at the same position.
    let key = |i: u32| mesh.positions[i as usize].map(f32::to_bits);
    let mut edges = std::collections::HashMap::new();
    for t in mesh.triangles.iter().filter(|t| mesh.surfaces[t[0] as usize] == 0) {
        for k in 0..3 {
            *edges.entry((key(t[k]), key(t[(k + 1) % 3]))).or_insert(0) += 1;
        }
    }
    let open = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a)));
    // Both sides of the walls are meshed; only edges at the rim stay open.
    let rim = |p: &[u32; 3]| (f32::from_bits(p[2]) - 2.0).abs() < 1e-6;
    let inside = open.filter(|(a, b)| !(rim(a) && rim(b))).count();
    assert!(inside * 100 < edges.len(), "{inside} of {}", edges.len());
}

// Guards (pictures): baked light has the power of the zones in every group.
#[test]
fn baked_powers_agree_with_the_zones_in_every_group() {
    let s = room();
    let b = baked(&s, &BakeOptions { min_edge: Some(0.01), tolerance: 0.02, ..BakeOptions::default() });
    let n = s.zones.patches.len();
    for (k, g) in s.groups.iter().enumerate() {
        let found: f64 = per_zone(&b.surfaces, &b.surfaces.irradiance[k], n).iter().sum();
        let wanted: f64 = (0..n)
            .map(|i| s.zones.patches[i].area * (g.incident.at(i).first() + g.direct.at(i).first()))
            .sum();
        assert!((found / wanted - 1.0).abs() < 0.01, "{}: {found} {wanted}", g.name);
    }
    assert_eq!(b.emission_groups, [None, None, Some(1)]);
}

// Guards (pictures): the groups of baked light sum to the total.
#[test]
fn baked_groups_sum_to_the_whole() {
    let apart = room();
    let whole = Solution { groups: Vec::new(), ..apart.clone() };
    let options = BakeOptions { min_edge: Some(10.0), ..BakeOptions::default() };
    let (a, w) = (baked(&apart, &options), baked(&whole, &options));
    // No cell is split, so that both have the same vertices.
    assert_eq!(a.surfaces.positions.len(), w.surfaces.positions.len());
    for i in 0..a.surfaces.positions.len() {
        for b in Band::all().map(Band::index) {
            let sum: f32 = a.surfaces.irradiance.iter().map(|g| g[i][b]).sum();
            let all = w.surfaces.irradiance[0][i][b];
            assert!((sum - all).abs() <= 1e-4 * all, "{sum} {all}");
        }
    }
    let (am, wm) = (a.medium.unwrap(), w.medium.unwrap());
    for c in 0..am.volume.len() {
        let sum: f32 = am.radiosity.iter().map(|g| g[c][0]).sum();
        assert!((sum - wm.radiosity[0][c][0]).abs() <= 1e-5 * sum.abs());
    }
    for i in 0..a.panes.positions.len() {
        let sum: f32 = a.panes.radiosity.iter().map(|g| g[i][0]).sum();
        assert!((sum - w.panes.radiosity[0][i][0]).abs() <= 1e-4 * sum);
    }
}

#[test]
fn vertex_limit_is_kept_and_refinement_reduces_the_error() {
    let s = room();
    let fine =
        |vertices| BakeOptions { min_edge: Some(0.004), max_vertices: vertices, ..BakeOptions::default() };
    let few = baked(&s, &fine(4000)).surfaces;
    assert!(few.positions.len() <= 4400 && few.positions.len() > 2000, "{}", few.positions.len());
    let many = baked(&s, &fine(20000)).surfaces;
    assert!(many.positions.len() > few.positions.len());
    // The sun's irradiance is more accurate with more vertices.
    let n = s.zones.patches.len();
    let off = |m: &SurfaceMesh| {
        let found = per_zone(m, &m.irradiance[0], n);
        let error = |i: usize| {
            let g = &s.groups[0];
            let p = &s.zones.patches[i];
            (found[i] - p.area * (g.incident.at(i).first() + g.direct.at(i).first())).abs()
        };
        (0..n).map(error).sum::<f64>()
    };
    assert!(off(&many) < off(&few), "{} {}", off(&many), off(&few));
    let none = baked(&s, &fine(0)).surfaces;
    assert!(none.triangles.len() <= 2 * n, "the mesh of the patch corners alone");
}

#[test]
fn shadow_edges_agree_with_shadow_rays() {
    let s = room();
    let b = baked(&s, &BakeOptions { min_edge: Some(0.01), ..BakeOptions::default() });
    let transport = Transport::new(&s.scene);
    let to_sun = vec3(-0.2, -0.3, 0.9).normalized();
    let (mut right, mut wrong) = (0, 0);
    let mesh = &b.surfaces;
    for i in (0..mesh.positions.len()).filter(|i| mesh.surfaces[*i] == 0) {
        let [p, n] = [mesh.positions[i], mesh.normals[i]].map(|x| Vec3::from_array(x.map(f64::from)));
        let inside = p + (vec3(0.0, 0.0, 1.0) - p) * 3e-4;
        let cos = n.dot(to_sun).max(0.0);
        let tau =
            transport.transmittance(inside, transport.exterior_point(inside, to_sun)).unwrap_or(Bands::ZERO);
        let expected = 0.5 * (1.0 + 0.3 * p.x + 0.1 * n.z) + 4.0 * tau.first() * cos;
        let fits = (mesh.irradiance[0][i][0] as f64 - expected).abs() < 0.05 * expected;
        *(if fits { &mut right } else { &mut wrong }) += usize::from(cos > 0.0);
    }
    // Vertices on the edge itself may fall on either side.
    assert!(right > 1000 && wrong * 20 < right, "{right} {wrong}");
}

// Guards (determinism): baked light does not depend on the number of threads.
#[test]
fn threads_do_not_change_a_bit() {
    let s = room();
    let options = BakeOptions { min_edge: Some(0.02), max_vertices: 3000, ..BakeOptions::default() };
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| baked(&s, &options))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}

/// The coarse mesh of the furnished room, by vertex the same for every mode of sunlight.
fn coarse(s: &Solution, sunlight: SunlightMode) -> BakedSolution {
    baked(s, &BakeOptions { min_edge: Some(10.0), sunlight, ..BakeOptions::default() })
}

#[test]
fn separate_sunlight_and_the_rest_sum_to_baked_light() {
    let apart = room();
    let whole = Solution { groups: Vec::new(), ..apart.clone() };
    let transport = Transport::new(&apart.scene);
    let sun = zonal_transport::lights::LightSampler::new(&apart.scene, &apart.scene.lights()[0]);
    for s in [&apart, &whole] {
        let (all, rest) = (coarse(s, SunlightMode::Baked), coarse(s, SunlightMode::Separate));
        assert_eq!((all.suns.len(), rest.suns.len()), (0, 1));
        let own = &rest.suns[0];
        assert_eq!((own.group, own.irradiance, own.angular_diameter), (0, [4.0, 2.0, 1.0], 0.0));
        assert_eq!((&all.panes, &all.medium), (&rest.panes, &rest.medium));
        let (a, r) = (&all.surfaces, &rest.surfaces);
        // With the sun, more vertices on patch borders differ in their light and are not merged.
        let at = |i: usize| (a.positions[i].map(f32::to_bits), a.normals[i].map(f32::to_bits));
        let first: std::collections::HashMap<_, _> = (0..a.positions.len()).map(|i| (at(i), i)).collect();
        let mut lit = 0;
        for i in 0..r.positions.len() {
            let k = first[&(r.positions[i].map(f32::to_bits), r.normals[i].map(f32::to_bits))];
            let [p, n] = [r.positions[i], r.normals[i]].map(|x| Vec3::from_array(x.map(f64::from)));
            let inside = p + (vec3(0.0, 0.0, 1.0) - p) * 1e-3;
            let receiver = zonal_transport::lights::Receiver::Surface(n);
            let h = sun.gather(&transport, inside, receiver, 1, 0).first();
            let (with, without) = (a.irradiance[0][k][0] as f64, r.irradiance[0][i][0] as f64);
            // Vertices at the edge of a shadow fall on either side.
            lit += usize::from(h > 0.5 && (with - without - h).abs() < 0.02 * h);
            assert!(with >= without - 0.05 * with && without > 0.0);
        }
        assert!(lit > 100, "{lit}");
        // The group of the sun alone has no direct light left, and others keep theirs.
        assert!(s.groups.is_empty() || r.direct[0].is_empty() && r.direct[1].len() == r.positions.len());
        assert!(s.groups.is_empty() || !a.direct[0].is_empty() && r.direct[2].is_empty());
    }
}

#[test]
fn direct_light_is_a_part_of_the_irradiance() {
    let b = coarse(&room(), SunlightMode::Baked);
    for (all, direct) in b.surfaces.irradiance.iter().zip(&b.surfaces.direct) {
        let pairs = all.iter().flatten().zip(direct.iter().flatten());
        assert!(pairs.clone().all(|(h, d)| *d >= 0.0 && d <= h));
    }
    let indirect = b.surfaces.irradiance[0][0][0] - b.surfaces.direct[0][0][0];
    let [p, n] = [b.surfaces.positions[0], b.surfaces.normals[0]];
    assert!((indirect - 0.5 * (1.0 + 0.3 * p[0] + 0.1 * n[2])).abs() < 0.05, "{indirect}");
}

#[test]
fn sun_depths_are_those_of_the_medium() {
    let s = room();
    let transport = Transport::new(&s.scene);
    let rest = coarse(&s, SunlightMode::Separate);
    let depths = rest.suns[0].depths.as_ref().unwrap();
    assert_eq!(depths.dims, [5; 3]);
    for (i, d) in depths.values.iter().enumerate() {
        let x = vec3((i / 25) as f64, (i / 5 % 5) as f64, (i % 5) as f64) * 0.5 - vec3(1.0, 1.0, 0.0);
        let expected = transport.medium_depth(x, transport.exterior_point(x, rest.suns[0].towards)).first();
        assert!((d[0] as f64 - expected).abs() < 1e-6 && expected <= 0.3 * 2.3, "{i}: {d:?} {expected}");
    }
}

#[test]
fn medium_without_separate_sunlight_keeps_the_rest() {
    let s = room();
    let grid = |sunlight, max_refined_points| {
        let options = volume_grid::VolumeGridOptions {
            max_refined_points,
            sunlight,
            ..volume_grid::VolumeGridOptions::default()
        };
        volume_grid::bake_volume_grid(&s, &options, &NoProgress).unwrap()
    };
    // On the voxels, and on a finer grid.
    for points in [0, 4096] {
        let (all, rest) = (grid(SunlightMode::Baked, points), grid(SunlightMode::Separate, points));
        assert_eq!(rest.albedo, [[0.5; 3]]);
        assert_eq!(all.radiosity[1..], rest.radiosity[1..]);
        let mean = |g: &volume_grid::VolumeGrid| {
            g.radiosity[0].iter().map(|b| b[0] as f64).sum::<f64>() / g.radiosity[0].len() as f64
        };
        // B = Ω/4 · G_dir of the sun, dimmed by the medium; a part is in the shadow of the board.
        let sun = mean(&all) - mean(&rest);
        let without_direct = |i: usize| {
            let (g, zone) = (&s.groups[0], s.zones.voxel_offset() + i);
            0.5 / 4.0 * g.incident.at(zone).first()
        };
        let wanted = (0..s.zones.voxels.len()).map(without_direct).sum::<f64>() / s.zones.voxels.len() as f64;
        assert!((mean(&rest) / wanted - 1.0).abs() < 0.02, "{} {wanted}", mean(&rest));
        let direct = |i: usize| 0.5 / 4.0 * s.groups[0].direct.at(s.zones.voxel_offset() + i).first();
        let zones = (0..s.zones.voxels.len()).map(direct).sum::<f64>() / s.zones.voxels.len() as f64;
        let lit = points == 0 || sun > 0.25 && sun < 0.5;
        assert!(lit && (points > 0 || (sun - zones).abs() < 1e-6), "{sun} {zones}");
    }
}

#[test]
fn steps_refine_one_mesh_and_end_with_the_last_or_an_error() {
    let s = room();
    let options = BakeOptions { tolerance: 0.02, max_vertices: 6000, ..BakeOptions::default() };
    let steps = |options: &BakeOptions, steps: &[usize]| {
        let mut out = Vec::new();
        let keep = |baked: BakedSolution, is_last: bool| -> Result<(), Infallible> {
            out.push((baked, is_last));
            Ok(())
        };
        assert!(bake_in_steps(&s, options, steps, &NoProgress, keep).is_ok());
        out
    };
    // The second step allows too few vertices to refine the first mesh; it is not published again.
    let all = steps(&options, &[10, 20, 4000]);
    assert!(all.iter().map(|x| x.1).eq([false, false, true]));
    let counts: Vec<usize> = all.iter().map(|x| x.0.surfaces.positions.len()).collect();
    assert!(counts[0] < 1000 && counts[1] > 2 * counts[0] && counts[2] > counts[1] + 500, "{counts:?}");
    let patches = s.zones.patches.len();
    let ones = |mesh: &SurfaceMesh| vec![[1.0f32; 3]; mesh.positions.len()];
    for (baked, _) in &all {
        let mesh = &baked.surfaces;
        let areas = per_zone(mesh, &ones(mesh), patches);
        assert!(areas.iter().zip(&s.zones.patches).all(|(a, p)| (a / p.area - 1.0).abs() < 1e-4));
        assert_eq!((&baked.panes, &baked.suns), (&all[2].0.panes, &all[2].0.suns));
    }
    // Without steps, or with steps that leave nothing to refine, there is the mesh of `bake`.
    assert_eq!(steps(&options, &[]), [(baked(&s, &options), true)]);
    let coarse = BakeOptions { tolerance: 10.0, ..options };
    assert_eq!(steps(&coarse, &[5000]), [(baked(&s, &coarse), true)]);
    let mut calls = 0;
    let fail = |_, _| {
        calls += 1;
        Err("stop")
    };
    assert_eq!(
        bake_in_steps(&s, &BakeOptions { tolerance: 0.02, ..coarse }, &[500], &NoProgress, fail),
        Err("stop")
    );
    assert_eq!(calls, 1);
}
