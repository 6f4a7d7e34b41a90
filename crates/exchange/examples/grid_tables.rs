//! Time and methods of a cube's tables: `grid_tables N KAPPA_L TOLERANCE`.
use std::time::Instant;
use zonal_exchange::aligned::lattice::GridTables;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let (n, kappa, tol) = (a[0] as usize, a[1] / a[0], a[2]);
    let edges = [1.0; 3];
    let counts = [n; 3];
    let t = Instant::now();
    let v = GridTables::new(edges, counts, kappa, tol).voxels();
    println!("vv {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = GridTables::new(edges, counts, kappa, tol).wall(0);
    println!("sv {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = GridTables::new(edges, counts, kappa, tol).adjacent([0, 1]);
    println!("ss adjacent {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let v = GridTables::new(edges, counts, kappa, tol).opposite(0);
    println!("ss opposite {} {:?} {:.3} s", v.len(), v.method_counts(), t.elapsed().as_secs_f64());
}
