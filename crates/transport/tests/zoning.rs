//! Zones: volumes and areas add up, walls separate, covered parts are excluded.
use crate::common;
use common::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::PatchRule;
use zonal_scene::{
    Bands, Facet, Light, Pane, Plate, Scene, SceneParts, Sides, Surface, Texture, Transmission, VoxelGrid,
    Zones,
};
use zonal_transport::{Transport, build_zones};

fn zones(s: &Scene) -> Zones {
    let z = build_zones(s, &Transport::new(s)).unwrap();
    if let Some(map) = s.voxel_grid() {
        let of_cells = (0..map.len()).flat_map(|c| z.voxel_zones_of_cell(c));
        assert!(of_cells.eq(0..z.voxels.len()));
        for c in 0..map.len() {
            for i in z.voxel_zones_of_cell(c) {
                let v = z.voxels.at(i);
                assert_eq!(v.cell, c);
                assert_eq!(map.cell_at(v.centre), Some(map.coordinates(c)));
                let sum: f64 = v.samples.iter().map(|s| s.volume).sum();
                assert!(v.samples.is_empty() || (sum - v.volume).abs() < 1e-12 * v.volume);
                assert!(v.samples.iter().zip(v.samples.iter().skip(1)).all(|(a, b)| a.subcell < b.subcell));
                assert!(v.volume > 0.0 && v.volume <= map.cell().product() * (1.0 + 1e-12));
            }
        }
    }
    for p in &z.patches {
        assert!((p.plate.area() - p.area).abs() < 1e-12 && p.area > 0.0);
        assert!((p.plate.normal() - p.normal).length() < 1e-12);
    }
    z
}

fn volume(z: &Zones) -> f64 {
    z.voxels.iter().map(|v| v.volume).sum()
}

fn area(z: &Zones, surface: usize) -> f64 {
    let of = z.patches.iter().filter(|p| p.surface == surface);
    of.map(|p| p.area).sum()
}

fn solid(name: &str) -> Surface {
    Surface { solid: true, ..surface(name) }
}

/// The unit room as surface 0 with 10 cm patches and `more` as surface 1.
fn furnished(more: Surface, plates: &[Plate], map: Option<VoxelGrid>) -> Scene {
    let walls = Surface { patch_size: Some(0.25), ..surface("walls") };
    let mut facets: Vec<Facet> = room(Vec3::ZERO, Vec3::ONE).iter().map(|p| facet(0, *p)).collect();
    facets.extend(plates.iter().map(|p| facet(1, *p)));
    scene(vec![walls, more], facets, map)
}

#[test]
fn room_on_the_grid_has_whole_cells_only() {
    let s = furnished(surface("more"), &[], Some(fog(5, 1.0)));
    let z = zones(&s);
    assert_eq!((z.patches.len(), z.voxels.len(), z.panes.len()), (96, 125, 0));
    assert!(z.voxels.iter().all(|v| v.samples.is_empty()));
    assert!((volume(&z) - 1.0).abs() < 1e-13);
    assert!((area(&z, 0) - 6.0).abs() < 1e-13);
    assert_eq!(z.patches[0].reflectance.to_rgb(), [0.5, 0.4, 0.3]);
    // A rotated room without a grid has patches only.
    let turned: Vec<Plate> = turned(&room(Vec3::ZERO, Vec3::ONE), Vec3::ZERO, 0.3);
    assert!((area(&zones(&plain(&turned, None)), 0) - 6.0).abs() < 1e-12);
}

// Guards (numbers): a voxel that a wall divides is two zones.
#[test]
fn wall_within_voxels_divides_each_into_two_zones() {
    for at in [0.5, 0.43, 0.5 + 1.0 / 48.0] {
        let wall = Plate::parallelogram(vec3(at, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        let s = furnished(surface("wall"), &mesh(&wall, 2), Some(fog(3, 1.0)));
        let z = zones(&s);
        assert_eq!(z.voxels.len(), 27 + 9);
        assert!((volume(&z) - 1.0).abs() < 1e-12);
        let dark: f64 = z.voxels.iter().filter(|v| v.centre.x < at).map(|v| v.volume).sum();
        assert!((dark - at).abs() < 1e-12, "{dark} against {at}");
        for v in z.voxels.iter().filter(|v| !v.samples.is_empty()) {
            let left = v.centre.x < at;
            assert!(v.samples.iter().all(|s| (s.point.x < at) == left));
        }
        let t = Transport::new(&s);
        assert!(t.has_occluders());
    }
    // A wall that ends in mid-cell leaves the cell in one piece.
    let half = Plate::parallelogram(vec3(0.5, 0.0, 0.0), vec3(0.0, 0.5, 0.0), vec3(0.0, 0.0, 1.0));
    let z = zones(&furnished(surface("wall"), &[half], Some(fog(3, 1.0))));
    assert_eq!(z.voxels.len(), 27 + 3);
    assert!((volume(&z) - 1.0).abs() < 1e-12);
}

#[test]
fn solids_reduce_the_volume_of_zones() {
    // On the grid: whole cells are removed.
    let block = solid_box(Vec3::splat(0.25), Vec3::splat(0.75));
    let s = furnished(solid("block"), &block, Some(fog(8, 1.0)));
    let z = zones(&s);
    assert_eq!(z.voxels.len(), 512 - 64);
    assert!(z.voxel_zones_of_cell(s.voxel_grid().unwrap().index([3, 3, 3])).is_empty());
    // Off the grid, axis-aligned: exact except at the edges. Oblique: to one per cent.
    for (angle, bound) in [(0.0, 1e-4), (0.5, 1e-3), (1.0, 1e-3)] {
        let centre = vec3(0.5, 0.48, 0.52);
        let block = turned(&solid_box(centre - Vec3::splat(0.21), centre + Vec3::splat(0.21)), centre, angle);
        for n in [4, 9] {
            let z = zones(&furnished(solid("block"), &block, Some(fog(n, 1.0))));
            let want = 1.0 - 0.42f64.powi(3);
            let off = (volume(&z) / want - 1.0).abs();
            assert!(off < bound * 9.0 / n as f64, "angle {angle}, {n} cells: {off}");
            for v in z.voxels.iter() {
                for p in v.samples.iter().map(|s| s.point).chain([v.centre]) {
                    let deep = block.iter().all(|f| (p - f.origin).dot(f.normal()) < -1e-9);
                    assert!(!deep, "a sample in the solid");
                }
            }
        }
    }
    // A thin solid plate between samples: no zone in it, and its volume is missing.
    let plate = solid_box(vec3(-0.1, -0.1, 0.6), vec3(1.1, 1.1, 0.61));
    let z = zones(&furnished(solid("plate"), &plate, Some(fog(2, 1.0))));
    assert!((volume(&z) - 0.99).abs() < 1e-9, "{}", volume(&z));
    assert_eq!(z.voxels.len(), 12);
}

#[test]
fn slivers_between_samples_belong_to_zones() {
    let block = |x: [f64; 2], y: [f64; 2]| solid_box(vec3(x[0], y[0], -0.1), vec3(x[1], y[1], 1.1));
    let all = [-0.1, 1.1];
    // Beside the borders of cells; between two solids in one cell; a hundredth of a cell; and in two directions.
    let cases = [
        (vec![block([0.51, 0.99], all)], 0.52, 16),
        (vec![block([0.31, 0.62], all), block([0.63, 0.88], all)], 0.44, 16),
        (vec![block([0.2525, 0.75], all)], 0.5025, 12),
        (vec![block([0.26, 0.74], [0.26, 0.74])], 1.0 - 0.48 * 0.48, 16),
    ];
    for (n, (blocks, want, columns)) in cases.into_iter().enumerate() {
        let s = furnished(solid("blocks"), &blocks.concat(), Some(fog(4, 1.0)));
        let z = zones(&s);
        let off = (volume(&z) / want - 1.0).abs();
        assert!(off < 2e-4, "{n}: {} of {want}", volume(&z));
        assert_eq!(z.voxels.len(), 4 * columns, "{n}");
        for p in z.voxels.iter().flat_map(|v| v.samples.iter()) {
            let hidden = |b: &Vec<Plate>| b.iter().all(|f| (p.point - f.origin).dot(f.normal()) < -1e-9);
            assert!(!blocks.iter().any(hidden), "{n}: a sample in a solid");
        }
    }
}

#[test]
fn volumes_at_cell_corners_are_exact() {
    // The medium's grid is larger than the room.
    let walls = room(vec3(0.07, 0.11, 0.03), vec3(0.91, 0.8, 0.88));
    let parts = SceneParts {
        surfaces: vec![surface("walls")],
        facets: walls.iter().map(|p| facet(0, *p)).collect(),
        voxel_grid: Some(fog(3, 1.0)),
        ..SceneParts::default()
    };
    let z = zones(&Scene::new(parts).unwrap());
    let [x, y, z0] = [[0.07, 0.91], [0.11, 0.8], [0.03, 0.88]];
    let length = |e: [f64; 2], i: usize| (e[1].min((i + 1) as f64 / 3.0) - e[0].max(i as f64 / 3.0)).max(0.0);
    assert_eq!(z.voxels.len(), 27);
    for v in z.voxels.iter() {
        let c = [v.cell / 9, v.cell / 3 % 3, v.cell % 3];
        let want = length(x, c[0]) * length(y, c[1]) * length(z0, c[2]);
        assert!((v.volume / want - 1.0).abs() < 1e-9, "{c:?}: {} of {want}", v.volume);
    }
}

#[test]
fn voxel_rule_cuts_partial_voxels_to_the_patch_size() {
    let count = |size: Option<f64>| {
        let lamp = Plate::parallelogram(vec3(0.3, 0.1, 0.5), vec3(0.1, 0.0, 0.0), vec3(0.0, 0.3, 0.0));
        let own = |name: &str| Surface { patch_size: size, ..surface(name) };
        let room = room(Vec3::ZERO, Vec3::ONE);
        let mut parts = SceneParts {
            surfaces: vec![own("walls"), own("lamp")],
            facets: room.iter().map(|p| facet(0, *p)).chain([facet(1, lamp)]).collect(),
            voxel_grid: Some(fog(4, 1.0)),
            ..SceneParts::default()
        };
        parts.options.patch_rule = PatchRule::Voxels;
        let z = zones(&Scene::new(parts).unwrap());
        [0, 1].map(|s| z.patches.iter().filter(|p| p.surface == s).count())
    };
    assert_eq!(count(None), [96, 2]);
    // 0.1 by 0.15 twice: two by three each. The walls fill voxels.
    assert_eq!(count(Some(0.06)), [96, 12]);
}

#[test]
fn patches_under_a_box_are_removed_and_none_straddles_a_wall() {
    // The box's edges cross patches of a quarter metre.
    let block = solid_box(vec3(0.3, 0.3, 0.0), vec3(0.6, 0.7, 0.5));
    let s = furnished(solid("block"), &block, None);
    let z = zones(&s);
    let foot = 0.3 * 0.4;
    assert!((area(&z, 0) - (6.0 - foot)).abs() < 1e-12, "{}", area(&z, 0));
    assert!((area(&z, 1) - (2.0 * 0.5 * 0.7 + foot)).abs() < 1e-12);
    let floor = z.patches.iter().filter(|p| p.surface == 0 && p.normal.z > 0.5);
    for p in floor.filter(|p| p.plate.origin.z < 0.5) {
        let (lo, hi) = p.plate.bounds();
        let separate = hi.x <= 0.3 + 1e-9 || lo.x >= 0.6 - 1e-9 || hi.y <= 0.3 + 1e-9 || lo.y >= 0.7 - 1e-9;
        assert!(separate, "{lo:?} {hi:?}");
    }
    // The bottom of the box is not a zone.
    assert!(!z.patches.iter().any(|p| p.surface == 1 && p.normal.z < -0.5));
}

/// A body in front of the wall x = 0, its back of many facets, which hides all of a patch but a strip of 4 mm; `off` is the distance
/// from the wall, at the level of single-precision rounding.
fn column(off: f64) -> Vec<Plate> {
    let (lo, hi) = (vec3(off, 0.254, 0.1), vec3(0.2, 0.5, 0.9));
    let mut plates: Vec<Plate> = room(lo, hi).iter().map(Plate::flipped).collect();
    let back = plates.iter().position(|p| p.normal().x < -0.5).unwrap();
    let whole = plates.remove(back);
    plates.extend(whole.quarters().iter().flat_map(|p| p.quarters()));
    plates
}

#[test]
fn visible_strip_beside_a_column_is_a_zone() {
    for off in [0.0, 5e-8, -5e-8] {
        let mut parts = SceneParts::default();
        let walls = Surface { patch_size: Some(0.25), ..surface("walls") };
        parts.facets = room(Vec3::ZERO, Vec3::ONE).iter().map(|p| facet(0, *p)).collect();
        parts.facets.extend(column(off).iter().map(|p| facet(1, *p)));
        parts.surfaces = vec![walls, solid("column")];
        parts.options.patch_rule = PatchRule::Area;
        let z = zones(&Scene::new(parts).unwrap());
        let wall = || z.patches.iter().filter(|p| p.surface == 0 && p.normal.x > 0.5);
        let hidden = |p: &zonal_scene::Patch| {
            let c = p.plate.centre();
            (c.y > 0.254 && c.y < 0.5) && (c.z > 0.1 && c.z < 0.9)
        };
        assert!(!wall().any(hidden), "{off}");
        let seen: f64 = wall().map(|p| p.area).sum();
        assert!((seen - (1.0 - 0.246 * 0.8)).abs() < 1e-6, "{off}: {seen}");
        assert!(wall().count() < 40, "{}", wall().count());
    }
}

#[test]
fn walls_split_the_patches_they_stand_on() {
    let walls = |tilt: f64| {
        let wall = Plate::parallelogram(vec3(0.4, 0.0, 0.0), vec3(tilt, 1.0, 0.0), vec3(0.0, 0.0, 0.6));
        zones(&furnished(surface("wall"), &mesh(&wall, 1), None))
    };
    let straight = walls(0.0);
    // 16 floor patches, of which the four in the second row become eight; two walls of 16 have a row with a foot that
    // stops at 0.6: two patches and the one in which it ends.
    assert!((area(&straight, 0) - 6.0).abs() < 1e-12);
    assert_eq!(straight.patches.iter().filter(|p| p.surface == 0).count(), 96 + 4 + 3 + 3);
    for tilt in [0.05, 0.3] {
        let z = walls(tilt);
        assert!((area(&z, 0) - 6.0).abs() < 1e-12);
        for p in z.patches.iter().filter(|p| p.surface == 0 && p.normal.z == 1.0) {
            let (c, n) = p.plate.corners();
            let side = c[..n].iter().map(|x| x.x - 0.4 - tilt * x.y);
            let (lo, hi) = side.fold((f64::MAX, f64::MIN), |(l, h), d| (l.min(d), h.max(d)));
            assert!(hi < 2e-3 || lo > -2e-3, "a patch from {lo} to {hi} across the wall");
        }
    }
    // A wall above the floor, one behind it, and one that only touches it split no patch.
    for (z0, dz) in [(0.1, 0.5), (-0.5, 0.5), (-0.5, 0.4)] {
        let wall = Plate::parallelogram(vec3(0.4, 0.2, z0), vec3(0.0, 0.5, 0.0), vec3(0.0, 0.0, dz));
        assert_eq!(
            zones(&furnished(surface("wall"), &[wall], None))
                .patches
                .iter()
                .filter(|p| p.surface == 0)
                .count(),
            96
        );
    }
}

/// The zones of a floor of one patch, or of the triangles of a mesh, on which panes stand.
fn floor_under(floor: &[Plate], panes: &[&[Plate]]) -> Zones {
    let floor_surface = Surface { patch_size: Some(2.0), ..surface("floor") };
    let pane = |plates: &&[Plate]| Pane {
        name: "glass".into(),
        plates: plates.to_vec(),
        thickness: 0.01,
        extinction: Bands::ONE,
        albedo: Bands::ZERO,
        emission: Bands::ZERO,
    };
    let scene = Scene::new(SceneParts {
        surfaces: vec![floor_surface],
        facets: floor.iter().map(|p| facet(0, *p)).collect(),
        panes: panes.iter().map(pane).collect(),
        ..SceneParts::default()
    });
    zones(&scene.unwrap())
}

/// Areas of the floor on the two sides of the plane m·x = c; no patch lies on both.
fn sides_of(z: &Zones, m: Vec3, c: f64) -> [f64; 2] {
    let mut out = [0.0; 2];
    for p in &z.patches {
        let (corners, n) = p.plate.corners();
        let h = corners[..n].iter().map(|x| m.dot(*x) - c);
        let (lo, hi) = h.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        assert!(lo > -1e-9 || hi < 1e-9, "a patch from {lo} to {hi} across the glass");
        out[usize::from(hi < 1e-9)] += p.area;
    }
    out
}

// Guards (numbers): no patch lies on both sides of a pane or of a sheet that transmits.
#[test]
fn panes_split_the_patches_they_stand_on() {
    let unit = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let of = |a: Vec3, b: Vec3, c: Vec3| Plate::parallelogram(a, b, c);
    let (up, along) = (vec3(0.0, 0.0, 1.0), vec3(0.0, 1.4, 0.0));
    for floor in [vec![unit], mesh(&unit, 1), mesh(&unit, 3)] {
        // Across the floor, however near to its edge; with its edge on the floor, a gap of 5 mm above, and sunk into it.
        for x in [0.5, 0.03, 0.001] {
            // A triangle's tip may be too short to be split off.
            if x < 0.01 && floor.len() > 1 {
                continue;
            }
            for z in [0.0, 0.005, -0.2] {
                let glass = of(vec3(x, -0.2, z), along, up);
                let found = sides_of(&floor_under(&floor, &[&[glass]]), vec3(1.0, 0.0, 0.0), x);
                assert!((found[0] - (1.0 - x)).abs() < 1e-9 && (found[1] - x).abs() < 1e-9, "{found:?}");
            }
        }
        // Turned and tilted, as two triangles.
        let m = vec3(0.8, 0.6, 0.3).normalized();
        let side = vec3(0.6, -0.8, 0.0);
        let glass =
            of(vec3(0.5, 0.5, 0.0) - side * 2.0 - m.cross(side) * 2.0, side * 4.0, m.cross(side) * 4.0);
        let halves = mesh(&glass, 1);
        for plates in [&[glass][..], &halves] {
            let z = floor_under(&floor, &[plates]);
            let found = sides_of(&z, m, m.dot(vec3(0.5, 0.5, 0.0)));
            assert!((found[0] - 0.5).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9, "{found:?}");
        }
    }
    // Glass that hangs higher, and glass below the floor.
    for z in [0.2, -1.1] {
        let glass = of(vec3(0.5, -0.2, z), along, up);
        assert_eq!(floor_under(&[unit], &[&[glass]]).patches.len(), 1);
    }
    // A pane that lies on the floor: its outline alone divides the patch.
    let cover = of(vec3(0.3, 0.2, 0.005), vec3(0.5, 0.0, 0.0), vec3(0.0, 0.5, 0.0));
    for plates in [vec![cover], mesh(&cover, 1)] {
        let z = floor_under(&[unit], &[&plates]);
        let inside = |p: Vec3| (0.3..0.8).contains(&p.x) && (0.2..0.7).contains(&p.y);
        let covered: f64 = z.patches.iter().filter(|p| inside(p.plate.centre())).map(|p| p.area).sum();
        assert!((covered - 0.25).abs() < 1e-9, "{covered}");
        assert_eq!(z.patches.len(), floor_under(&[unit], &[&[cover]]).patches.len());
    }
}

#[test]
fn sheets_that_transmit_split_off_narrow_strips() {
    let unit = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let sheet = Plate::parallelogram(vec3(0.001, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let pieces = |transmittance: Option<f64>| {
        let mut own = Surface { sides: Sides::Both, ..surface("sheet") };
        own.transmission =
            transmittance.map(|t| Transmission { transmittance: Bands::splat(t), texture: None });
        let floor = Surface { patch_size: Some(2.0), ..surface("floor") };
        let z = zones(&scene(vec![floor, own], vec![facet(0, unit), facet(1, sheet)], None));
        z.patches.iter().filter(|p| p.surface == 0).count()
    };
    assert_eq!((pieces(None), pieces(Some(0.3))), (1, 2));
}

#[test]
fn two_sided_surfaces_have_two_zones_with_averaged_texture() {
    let plate = Plate::parallelogram(vec3(0.2, 0.2, 0.5), vec3(0.5, 0.0, 0.0), vec3(0.0, 0.5, 0.0));
    let mut sheet = surface("sheet");
    sheet.sides = Sides::Both;
    sheet.patch_size = Some(0.25);
    sheet.reflectance = Bands::ONE;
    sheet.reflectance_texture = Some(0);
    let s = Scene::new(SceneParts {
        surfaces: vec![sheet],
        facets: vec![facet(0, plate)],
        textures: vec![Texture {
            width: 64,
            height: 1,
            pixels: (0..64).map(|i| [i as f32 / 64.0, 0.5, 0.0]).collect(),
        }],
        lights: vec![Light::Emitter { surface: 0, name: None }],
        panes: vec![Pane {
            name: "glass".into(),
            plates: vec![plate],
            thickness: 0.01,
            extinction: Bands::ONE,
            albedo: Bands::splat(0.5),
            emission: Bands::ZERO,
        }],
        ..SceneParts::default()
    })
    .unwrap();
    let z = zones(&s);
    assert_eq!(z.patches.len(), 8);
    assert_eq!(z.patches.iter().filter(|p| p.normal.z > 0.0).count(), 4);
    assert!(z.patches.iter().all(|p| p.emission == Bands::ZERO));
    for p in &z.patches {
        let x = (p.plate.centre().x - 0.2) / 0.5;
        let [red, green, _] = p.reflectance.to_rgb();
        assert!((red - x).abs() < 0.03 && (green - 0.5).abs() < 1e-6);
    }
    let glass: f64 = z.panes.iter().map(|p| p.area).sum();
    assert!((glass - 0.25).abs() < 1e-14);
    assert!(z.panes.iter().all(|p| p.pane == 0 && p.thickness == 0.01));
}

#[test]
fn excess_patches_are_refused_with_the_surface_name() {
    let mut tiny = surface("wall");
    tiny.patch_size = Some(1e-7);
    let plates = room(Vec3::ZERO, Vec3::ONE);
    let s = scene(vec![tiny], plates.iter().map(|p| facet(0, *p)).collect(), None);
    let e = build_zones(&s, &Transport::new(&s)).unwrap_err();
    assert_eq!(e.key(), "surface 'wall'.patch_size");
    assert!(e.message().contains("larger"), "{e}");
}

// Guards (determinism): zones do not depend on the number of threads.
#[test]
fn zones_do_not_depend_on_the_number_of_threads() {
    let block = turned(&solid_box(Vec3::splat(0.3), Vec3::splat(0.6)), Vec3::splat(0.5), 0.7);
    let fine: Vec<Plate> = block.iter().flat_map(|p| mesh(p, 4)).collect();
    let s = furnished(solid("block"), &fine, Some(fog(9, 1.0)));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| zones(&s))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn oblique_wall_separates_the_volumes_of_both_sides() {
    // An oblique thin wall from floor to ceiling: no sample of one side sees one of the other.
    let wall = Plate::parallelogram(vec3(0.2, 0.0, 0.0), vec3(0.55, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let s = furnished(surface("wall"), &[wall], Some(fog(6, 1.0)));
    let z = zones(&s);
    let side = |p: Vec3| (p - wall.origin).dot(wall.normal());
    let mut sums = [0.0; 2];
    for v in z.voxels.iter() {
        let front = side(v.centre) > 0.0;
        sums[front as usize] += v.volume;
        assert!(v.samples.iter().all(|s| (side(s.point) > 0.0) == front));
    }
    // x < 0.2 + 0.55 y
    let left = 0.2 + 0.275;
    assert!((sums[0] + sums[1] - 1.0).abs() < 2e-3, "{sums:?}");
    assert!(sums.iter().any(|s| (s - left).abs() < 2e-3), "{sums:?}");
}

fn of_plate(p: Plate, size: f64, rule: PatchRule) -> Result<Zones, zonal_scene::SceneError> {
    let mut parts =
        SceneParts { surfaces: vec![surface("blade")], facets: vec![facet(0, p)], ..SceneParts::default() };
    parts.options.patch_size = Some(size);
    parts.options.patch_rule = rule;
    let s = Scene::new(parts).unwrap();
    build_zones(&s, &Transport::new(&s))
}

#[test]
fn number_of_pieces_grows_with_the_length_of_needles() {
    let rules = [PatchRule::Edge, PatchRule::Area];
    for (length, rule) in [100.0, 1e3, 5e3].into_iter().flat_map(|l| rules.map(|r| (l, r))) {
        for apex in [0.0, 0.3, 0.5, 1.0] {
            let needle = Plate::triangle(Vec3::ZERO, vec3(0.0, length, 0.0), vec3(1.0, apex * length, 0.0));
            let sheared =
                Plate::parallelogram(Vec3::ZERO, vec3(0.0, length, 0.0), vec3(1.0, apex * length, 0.0));
            for p in [needle, sheared, needle.flipped()] {
                let z = of_plate(p, 1.0, rule).unwrap();
                let limit = if p.kind == zonal_scene::PlateKind::Triangle { 2.2 } else { 4.4 };
                assert!(
                    (z.patches.len() as f64) < limit * length + 10.0,
                    "{} pieces of {length} m, {rule:?}",
                    z.patches.len()
                );
                let area: f64 = z.patches.iter().map(|q| q.area).sum();
                assert!((area / p.area() - 1.0).abs() < 1e-9);
                assert!(z.patches.iter().all(|q| q.normal.dot(p.normal()) > 0.999));
                let longest = if rule == PatchRule::Area { 6.5 } else { 2.5 };
                assert!(z.patches.iter().all(|q| q.plate.diameter() < longest));
            }
        }
    }
}

#[test]
fn wide_needles_have_pieces_as_large_as_the_patch_size() {
    // 10 m wide and 1 km long: pieces of 1 m along the tip, and of the whole width beyond.
    let p = Plate::triangle(Vec3::ZERO, vec3(0.0, 1000.0, 0.0), vec3(10.0, 0.0, 0.0));
    let z = of_plate(p, 1.0, PatchRule::Edge).unwrap();
    assert!(z.patches.iter().all(|q| q.plate.diameter() < 2.5));
    assert!((5_000..30_000).contains(&z.patches.len()), "{}", z.patches.len());
}

// Guards (files): no file makes the program allocate memory out of proportion to its size.
#[test]
fn too_many_pieces_are_refused_before_they_are_made() {
    let needle = Plate::triangle(Vec3::ZERO, vec3(0.0, 1e8, 0.0), vec3(1e-3, 0.0, 0.0));
    let skewed = Plate::parallelogram(Vec3::ZERO, vec3(1e7, 0.0, 0.0), vec3(9e6, 1.0, 0.0));
    let square = Plate::parallelogram(Vec3::ZERO, vec3(1e7, 0.0, 0.0), vec3(0.0, 1e7, 0.0));
    for (p, size) in [(needle, 1e-2), (skewed, 1e-3), (square, 1e-6), (needle, 1e-300)] {
        for rule in [PatchRule::Edge, PatchRule::Area] {
            let e = of_plate(p, size, rule).unwrap_err();
            let text = e.to_string();
            assert!(text.contains("surface 'blade'") && text.contains("larger patch_size"), "{text}");
        }
    }
    let pane = Pane {
        name: "glass".into(),
        plates: vec![needle],
        thickness: 0.01,
        extinction: Bands::ONE,
        albedo: Bands::ZERO,
        emission: Bands::ZERO,
    };
    let mut parts = SceneParts { panes: vec![pane], ..SceneParts::default() };
    parts.options.patch_size = Some(1e-2);
    let s = Scene::new(parts).unwrap();
    let text = build_zones(&s, &Transport::new(&s)).unwrap_err().to_string();
    assert!(text.contains("pane 'glass'"), "{text}");
}
