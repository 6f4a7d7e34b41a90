//! The hemi-cube against the reference table: patches and voxels, attenuated or not.

use zonal_exchange::AccuracyRequest;
use zonal_math::{Vec3, vec3};
use zonal_paper::hemicube::{HemicubeRaster, HemicubeTarget, pair_factor, patch_factors};
use zonal_scene::Plate;

/// The plate of a flat box whose normal is the axis `k`, up or down.
fn plate(lo: Vec3, hi: Vec3, k: usize, up: bool) -> Plate {
    let edge = |axis: usize| {
        let mut e = [0.0; 3];
        e[axis] = (hi - lo)[axis];
        Vec3::from_array(e)
    };
    let p = Plate::parallelogram(lo, edge((k + 1) % 3), edge((k + 2) % 3));
    if up { p } else { p.flipped() }
}

#[test]
fn hemicube_radius_contains_the_reference_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../exchange/tests/data/direct_exchange.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let demand = AccuracyRequest { tolerance: 5e-2, max_evaluations: 1_000_000 };
    let (mut rows, mut met, mut worst) = (0, 0, 0.0f64);
    for line in text.lines().filter(|l| l.starts_with("sv")) {
        let c: Vec<&str> = line.split(',').collect();
        let x = |i: usize| c[i].parse::<f64>().unwrap();
        let zone = |i: usize| (vec3(x(i), x(i + 2), x(i + 4)), vec3(x(i + 1), x(i + 3), x(i + 5)), c[i + 6]);
        let (a, b) = (zone(1), zone(8));
        let (flat, solid) = if a.2.is_empty() { (b, a) } else { (a, b) };
        let k = "xyz".find(&flat.2[1..]).unwrap();
        let patch = plate(flat.0, flat.1, k, !flat.2.starts_with('-'));
        let want = x(16);
        let f = pair_factor(&patch, &HemicubeTarget::Cuboid(solid.0, solid.1), x(15), &demand).bounded;
        assert!(f.contains(want), "{line}: {f:?}");
        met += usize::from(f.radius <= demand.tolerance * f.value);
        rows += 1;
        worst = worst.max((f.value / want - 1.0).abs());
    }
    println!("{rows} rows, {met} to 5 %, worst relative error {worst:.1e}");
    // Voxels ten edges off are a dozen pixels wide, and where patch and voxel touch in a thick medium the pieces run out.
    assert!(rows == 32 && met >= 20 && worst < 0.05);
}

fn square(z: f64) -> Plate {
    Plate::parallelogram(vec3(0.0, 0.0, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
}

#[test]
fn factors_of_a_room_sum_to_one_with_occluders() {
    let walls = |z: f64| {
        let e = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, z)];
        [
            Plate::parallelogram(e[2], e[1], e[0]),
            Plate::parallelogram(Vec3::ZERO, e[1], e[2]),
            Plate::parallelogram(e[0], e[2], e[1]),
            Plate::parallelogram(Vec3::ZERO, e[2], e[0]),
            Plate::parallelogram(e[1], e[0], e[2]),
        ]
    };
    let raster = HemicubeRaster { resolution: 64, halvings: 1 };
    let mut targets: Vec<HemicubeTarget> = walls(1.0).into_iter().map(HemicubeTarget::Plate).collect();
    let sum = |t: &[HemicubeTarget]| {
        patch_factors(&square(0.0), t, 0.0, raster).iter().map(|f| f.bounded.value).sum::<f64>()
    };
    // The pixels themselves sum to one within 1e-3 at this resolution.
    assert!((sum(&targets) - 1.0).abs() < 1e-3, "{}", sum(&targets));
    // A lid half way up takes all of the ceiling's share and adds to its own.
    targets.push(HemicubeTarget::Plate(square(0.5).flipped()));
    let f = patch_factors(&square(0.0), &targets, 0.0, raster);
    assert_eq!(f[0].bounded.value, 0.0);
    assert!((sum(&targets) - 1.0).abs() < 1e-3);
    // A box above the lid has no factor; of one across it only the lower part counts.
    let boxes = |z0: f64, z1: f64| HemicubeTarget::Cuboid(vec3(0.0, 0.0, z0), vec3(1.0, 1.0, z1));
    let mut cut = targets.clone();
    cut.extend([boxes(0.6, 1.0), boxes(0.2, 0.9), boxes(0.2, 0.5)]);
    let f = patch_factors(&square(0.0), &cut, 0.3, raster);
    assert_eq!(f[6].bounded.value, 0.0);
    assert!((f[7].bounded.value / f[8].bounded.value - 1.0).abs() < 1e-12 && f[8].bounded.value > 0.0);
}
