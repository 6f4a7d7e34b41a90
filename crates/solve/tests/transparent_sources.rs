//! Sources in voxels without extinction: closed forms, the path tracer, and the engines that have them.

use crate::common;

use common::{read, solve, unit_room};
use zonal_reference::path_tracer::{Detector, PathTracer};
use zonal_scene::{Band, Bands, NoProgress, Solution};

/// The unit room with a medium of eight cells.
fn glow(engine: &str, walls: &str, medium: &str) -> Solution {
    solve(read(&unit_room(
        &format!("tolerance = 0.002\npatch_size = 0.5\npatch_rule = \"voxels\"\nengine = \"{engine}\""),
        walls,
        &format!("[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\n{medium}"),
    )))
}

#[test]
fn the_power_of_a_transparent_source_reaches_the_walls() {
    // In the last band the source is in a medium.
    let medium = "extinction = [0, 0, 0.5]\nalbedo = 0\nsource = [6, 3, 6]";
    for engine in ["dense", "spectral", "auto"] {
        let s = glow(engine, "reflectance = [0, 0.4, 0]", medium);
        let e = &s.report.energy;
        let walls: Bands = e.absorbed_surfaces.iter().map(|r| r.1).sum();
        // All of q V, by symmetry a sixth on each wall: H = q V/(6 (1 − ρ)).
        for (b, [power, h]) in Band::all().zip([[6.0, 1.0], [3.0, 0.5 / 0.6]]) {
            assert!((walls[b] / power - 1.0).abs() < 2e-3, "{engine}: {:?}", walls);
            let total: f64 =
                (0..s.zones.voxel_offset()).map(|i| s.zones.patches[i].area * s.fields.incident[i][b]).sum();
            assert!((total / (6.0 * h) - 1.0).abs() < 2e-3, "{engine}: {total}");
        }
        assert!((e.emitted - Bands::from_rgb([6.0, 3.0, 6.0])).abs().max_element() < 1e-9, "{:?}", e.emitted);
        assert!(e.residual.all(|r| r.abs() < 2e-3), "{engine}: {:?}", e.residual);
    }
}

#[test]
fn fluence_and_irradiance_agree_with_the_path_tracer() {
    let s = glow(
        "dense",
        "reflectance = 0\nomit = [\"z1\"]",
        "[[medium.region]]\nbox = { min = [0,0,0], max = [0.5,0.5,0.5] }\nsource = 8",
    );
    let tracer = PathTracer::new(&s.scene);
    for i in [0, s.zones.voxel_offset(), s.zones.voxel_offset() + 7] {
        let detector = match s.zones.patches.get(i) {
            Some(p) => Detector::patch(p),
            None => {
                let grid = s.scene.voxel_grid().unwrap();
                Detector::voxel(s.zones.voxels.at(i - s.zones.voxel_offset()), grid)
            }
        };
        let traced = tracer.measure_one(&detector, 60_000, 3).total[Band::first()];
        let found = s.fields.incident[i].first();
        assert!(
            (found - traced.value).abs() < 0.005 * traced.value + 3.0 * traced.error,
            "{i}: {found} for {traced:?}"
        );
    }
}

#[test]
fn the_rays_engine_refuses_them() {
    let text = unit_room(
        "engine = \"rays\"",
        "reflectance = 0.5",
        "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [2,2,2]\nextinction = 0\nsource = 1",
    );
    let error = zonal_solve::solve(read(&text), 1 << 30, &NoProgress).unwrap_err().to_string();
    assert!(error.contains("no extinction") && error.contains("dense"), "{error}");
}
