//! View3D's printed matrices.

#[path = "support/view3d.rs"]
mod support;

use support::{Surface, polygons, printed, surfaces, text};
use zonal_exchange::Demand;
use zonal_exchange::polygon::visible::{Polygon, exchange};

fn matrix(all: &[Surface], tolerance: f64, floor: f64) -> Vec<Vec<f64>> {
    let parts: Vec<Vec<Polygon>> = all.iter().map(polygons).collect();
    let obstructions: Vec<Polygon> = parts.iter().flatten().cloned().collect();
    let n = all.len();
    let mut f = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..i {
            for a in &parts[i] {
                for b in &parts[j] {
                    let t = std::time::Instant::now();
                    let x = exchange(a, b, &obstructions, &Demand::relative(tolerance), floor);
                    if t.elapsed().as_secs_f64() > 0.2 {
                        println!("{i} {j} {:?} {:?}", x, t.elapsed());
                    }
                    f[i][j] += x.bounded.value;
                }
            }
            f[j][i] = f[i][j];
        }
    }
    f
}

#[test]
fn first_look() {
    for (name, want) in [
        ("examples/test4.vs3", "test/viewht/test-viewfactors.txt"),
        ("test/3d/test.vs3", "test/3d/test-expected-output.txt"),
    ] {
        let Some(t) = text(name) else { return };
        let s = surfaces(&t, 4);
        let w = printed(&text(want).unwrap());
        let f = matrix(&s, 1e-6, 1e-6);
        let area: Vec<f64> = s.iter().map(|s| polygons(s).iter().map(|p| p.area()).sum()).collect();
        for i in 0..s.len() {
            println!("{i} {}", f[i].iter().sum::<f64>() / area[i] - 1.0);
        }
        println!("{:?} {:?}", w.areas, w.emissivities);
    }
}
