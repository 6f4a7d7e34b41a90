//! Total exchange areas: against View3D's printed matrices, and against the solve.

use crate::common;
#[allow(dead_code)]
#[path = "../../view-factors/tests/support/view3d.rs"]
mod view3d;

use common::{read, solved};
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Vec3;
use zonal_reference::visible_views::VisibleScene;
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_solve::areas::total_exchange_areas::{TotalExchangeAreas, total_exchange_areas};

const FURNACE: &str = "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nengine = \"dense\"\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [2,2,4] }\ntemperature = 900\nemissivity = 0.7\nfaces.z0 = { temperature = 1200, emissivity = 0.85 }\nfaces.z1 = { temperature = 400 }\n[medium]\nmin = [0,0,0]\nmax = [2,2,4]\ncells = [2, 2, 4]\nextinction = 0.5\nalbedo = 0.4\ntemperature = 1100\n";

/// The factors of polygons by exact views from points.
fn factors(walls: &[ConvexPolygon]) -> Vec<Vec<f64>> {
    let facets: Vec<Vec<Vec3>> = walls.iter().map(|w| w.corners().to_vec()).collect();
    let rows = VisibleScene::new(&facets, &[]).rows(1e-6, 10_000);
    rows.iter().map(|row| row.facets.iter().map(|f| f.value).collect()).collect()
}

#[test]
fn total_areas_match_view3d() {
    let Some(input) = view3d::text("examples/test4.vs3") else { return };
    let s = view3d::surfaces(&input);
    let (areas, f) = view3d::combined(&s, &view3d::exchange_areas(&s, factors));
    let n = areas.len();
    let flat: Vec<f64> =
        (0..n * n).map(|k| 0.5 * (areas[k / n] * f[k / n][k % n] + areas[k % n] * f[k % n][k / n])).collect();
    let e = view3d::EMISSIVITY;
    let t: TotalExchangeAreas =
        total_exchange_areas(&flat, &vec![1e-6; n * n], &areas, &vec![1.0 - e; n]).unwrap();
    let ours = |i: usize, j: usize| t.areas[i * n + j] / areas[i];
    // The same by elimination.
    let grey = view3d::grey(&f, e);
    let w = view3d::printed(&view3d::text("test/viewht/test-viewfactors.txt").unwrap());
    for i in 0..n {
        let row: f64 = (0..n).map(|j| ours(i, j)).sum();
        assert!((row - e).abs() < 1e-6, "row {i} sums to {row}");
        for j in 0..n {
            assert!((ours(i, j) - grey[i][j]).abs() < 1e-6, "{i} {j}");
            // Printed at a tolerance of 1e-4.
            assert!(
                (ours(i, j) - w.matrix[i][j]).abs() < 1.5e-4,
                "{i} {j}: {} {}",
                ours(i, j),
                w.matrix[i][j]
            );
        }
    }
    // Back to the view factors by View3D's formula.
    let mut g = vec![vec![0.0; n]; n];
    (0..n * n).for_each(|k| g[k / n][k % n] = ours(k / n, k % n));
    for (a, b) in view3d::plain(&g, e).iter().flatten().zip(f.iter().flatten()) {
        assert!((a - b).abs() < 2e-6);
    }
}

#[test]
fn total_areas_give_the_net_fluxes() {
    // An enclosure of known temperatures: net powers by T equal those of the solve.
    let (s, scene) = (solved(FURNACE), read(FURNACE));
    let (t, closure) = common::with_exchange(&scene, |zones, _, exchange| {
        let n = zones.len();
        let own = |k: usize| scaled_radiosity_coefficient(zones, k).first();
        let c: Vec<f64> = (0..n).map(|i| closure_target(zones, i) * own(i)).collect();
        let mut f = vec![0.0; n * n];
        for i in 0..n {
            let (row, mut counts) = (exchange.row(i), common::count());
            for j in 0..=i {
                let x = exchange.pair_in_row(&row, j, &mut counts).value.first() * own(i) * own(j);
                (f[i * n + j], f[j * n + i]) = (x, x);
            }
        }
        let part = |i: usize| if i < zones.voxel_offset() { 1.0 } else { 4.0 };
        let r: Vec<f64> = (0..n).map(|i| zones.response(i).0.first() * part(i)).collect();
        let closure: Vec<f64> = c.iter().zip(&r).map(|(c, r)| c * (1.0 - r)).collect();
        (total_exchange_areas(&f, &vec![0.0; n * n], &c, &r).unwrap(), closure)
    });
    let n = closure.len();
    let heat = s.fields.heat.as_ref().unwrap();
    let e: Vec<f64> = heat.temperature.iter().map(|t| blackbody_emissive_power(*t)).collect();
    for i in 0..n {
        let row: f64 = t.areas[i * n..(i + 1) * n].iter().sum();
        assert!((row / closure[i] - 1.0).abs() < 1e-9);
        let net: f64 = (0..n).map(|j| t.areas[i * n + j] * (e[i] - e[j])).sum();
        let want = heat.net[i] * s.zones.response(i).1;
        assert!(
            (net - want).abs() < 1e-6 * closure[i] * blackbody_emissive_power(1200.0),
            "zone {i}: {net} {want}"
        );
    }
}
