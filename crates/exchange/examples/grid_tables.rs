//! Time and methods of a cube's tables: `grid_tables N KAPPA_L TOLERANCE`.
use std::time::Instant;
use zonal_exchange::aligned::lattice::{OffsetTable, WallTable};
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let (n, kappa, tol) = (a[0] as usize, a[1] / a[0], a[2]);
    let edges = [1.0; 3];
    let counts = [n; 3];
    let t = Instant::now();
    let v = OffsetTable::new(edges, counts, kappa, tol);
    println!("vv {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = WallTable::voxels(edges, counts, 0, kappa, tol);
    println!("sv {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = WallTable::adjacent(edges, counts, [0, 1], kappa, tol);
    println!("ss adjacent {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = WallTable::opposite(edges, counts, 0, kappa, tol);
    println!("ss opposite {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
}
