//! TotalExchangeAreas exchange areas: power emitted by a zone and absorbed by another after any number of reflections and scattering events
//! (Hottel & Sarofim, Radiative Transfer, ch. 3).
//!
//! With direct areas F_ij, c_i = A_i or 4κ_iV_i, r_i = ρ_i or Ω_i, a = 1 − r and D = diag(r/c), radiosities are B = a E + D P, incident power is
//! P = F B, and zone i absorbs a_i P_i. The net power from zone i to zone j is T_ij (E_i − E_j), E = σT⁴, with
//!
//! ```text
//!     T = a F (I − D F)⁻¹ a = a (F + XᵀX) a          LLᵀ = I − √D F √D,  L X = √D F
//! ```
//!
//! symmetric by construction; in a closed scene its rows sum to a_i c_i (Σ_j F_ij = c_i): ε A of a surface, 4κ_aV of a volume. The Cholesky
//! decomposition exists as long as some power is lost.
//!
//! **Errors.** To first order δT = Kᵀ δF K with K = (I + D (F + XᵀX)) a, which has no negative entry: the radii of F propagate as bounds.
//!
//! Cost: about 4n³ multiplications, and 5n² numbers beside F and its radii.

use zonal_math::parallel;

/// Rows of a block of the blocked loops.
const BLOCK_ROWS: usize = 64;

/// Numbers for each pair of zones beside F and its radii: T, its radii, and three intermediate matrices.
pub(crate) const NUMBERS_PER_PAIR: u64 = 5;

/// T and its error radii, m², row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct TotalExchangeAreas {
    /// T_ij.
    pub areas: Vec<f64>,
    /// Error radii.
    pub radii: Vec<f64>,
}

/// AᵀB, row by row; the order of the sums does not depend on the number of threads.
fn transposed_product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    parallel::chunks(&mut out, n * BLOCK_ROWS, |block, rows| {
        for k in 0..n {
            let from = &b[k * n..(k + 1) * n];
            for (i, row) in rows.chunks_mut(n).enumerate() {
                let x = a[k * n + block * BLOCK_ROWS + i];
                if x != 0.0 {
                    row.iter_mut().zip(from).for_each(|(o, b)| *o += x * b);
                }
            }
        }
    });
    out
}

/// Replaces the lower half of a symmetric matrix by its Cholesky factor L; `None` if it is not positive definite.
fn cholesky(m: &mut [f64], n: usize) -> Option<()> {
    for from in (0..n).step_by(BLOCK_ROWS) {
        let to = (from + BLOCK_ROWS).min(n);
        // Factor the diagonal block.
        for i in from..to {
            for j in from..=i {
                let sum: f64 = (from..j).map(|k| m[i * n + k] * m[j * n + k]).sum();
                let x = m[i * n + j] - sum;
                if i > j {
                    m[i * n + j] = x / m[j * n + j];
                } else if x > 0.0 {
                    m[i * n + i] = x.sqrt();
                } else {
                    return None;
                }
            }
        }
        let (done, rest) = m.split_at_mut(to * n);
        // Solve for the panel below, then update the rest.
        parallel::chunks(rest, n, |_, row| {
            for j in from..to {
                let own = &done[j * n..];
                let sum: f64 = (from..j).map(|k| row[k] * own[k]).sum();
                row[j] = (row[j] - sum) / own[j];
            }
        });
        let panel: Vec<f64> = rest.chunks(n).flat_map(|r| r[from..to].to_vec()).collect();
        let width = to - from;
        parallel::chunks(rest, n, |i, row| {
            let own = &panel[i * width..(i + 1) * width];
            for (j, other) in panel.chunks(width).enumerate().take(i + 1) {
                let sum: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
                row[to + j] -= sum;
            }
        });
    }
    Some(())
}

/// Replaces B by the solution X of L X = B.
fn solve_lower(l: &[f64], b: &mut [f64], n: usize) {
    for from in (0..n).step_by(BLOCK_ROWS) {
        let to = (from + BLOCK_ROWS).min(n);
        for i in from..to {
            let (done, rest) = b.split_at_mut(i * n);
            let row = &mut rest[..n];
            for k in from..i {
                let x = l[i * n + k];
                row.iter_mut().zip(&done[k * n..(k + 1) * n]).for_each(|(r, d)| *r -= x * d);
            }
            let own = l[i * n + i];
            row.iter_mut().for_each(|r| *r /= own);
        }
        let (done, rest) = b.split_at_mut(to * n);
        parallel::chunks(rest, n, |i, row| {
            for k in from..to {
                let x = l[(to + i) * n + k];
                row.iter_mut().zip(&done[k * n..(k + 1) * n]).for_each(|(r, d)| *r -= x * d);
            }
        });
    }
}

/// T of all zones from direct areas and their radii (m², row by row), c (m²) and r. `None` if no power is lost, so that the series diverges.
#[must_use]
pub fn total_exchange_areas(
    areas: &[f64],
    radii: &[f64],
    c: &[f64],
    r: &[f64],
) -> Option<TotalExchangeAreas> {
    let n = c.len();
    let root: Vec<f64> = c.iter().zip(r).map(|(c, r)| if *c > 0.0 { (r / c).sqrt() } else { 0.0 }).collect();
    let absorb: Vec<f64> = c.iter().zip(r).map(|(c, r)| if *c > 0.0 { 1.0 - r } else { 0.0 }).collect();
    if n == 0 {
        return Some(TotalExchangeAreas { areas: Vec::new(), radii: Vec::new() });
    }
    let mut l = vec![0.0; n * n];
    parallel::chunks(&mut l, n, |i, row| {
        for (j, x) in row.iter_mut().enumerate() {
            *x = f64::from(u8::from(i == j)) - root[i] * areas[i * n + j] * root[j];
        }
    });
    cholesky(&mut l, n)?;
    let mut x: Vec<f64> = areas.to_vec();
    parallel::chunks(&mut x, n, |i, row| row.iter_mut().for_each(|v| *v *= root[i]));
    solve_lower(&l, &mut x, n);
    drop(l);
    // Y = F + XᵀX; both halves are the same sums in the same order.
    let mut y = transposed_product(&x, &x, n);
    drop(x);
    parallel::for_each_pair(&mut y, areas, |y, f| *y += f);
    // K, with column j times a_j.
    let mut k = vec![0.0; n * n];
    parallel::chunks(&mut k, n, |i, row| {
        for (j, v) in row.iter_mut().enumerate() {
            *v = (f64::from(u8::from(i == j)) + root[i] * root[i] * y[i * n + j]) * absorb[j];
        }
    });
    let half = transposed_product(radii, &k, n);
    let radii = transposed_product(&half, &k, n);
    drop((half, k));
    parallel::chunks(&mut y, n, |i, row| {
        row.iter_mut().zip(&absorb).for_each(|(v, a)| *v *= absorb[i] * a);
    });
    Some(TotalExchangeAreas { areas: y, radii })
}

/// Sums of a matrix over groups of zones, row by row; `group[i]` < `groups` is the group of zone i.
pub(crate) fn sum_by_group(matrix: &[f64], group: &[usize], groups: usize) -> Vec<f64> {
    let n = group.len();
    let mut out = vec![0.0; groups * groups];
    for i in 0..n {
        for j in 0..n {
            out[group[i] * groups + group[j]] += matrix[i * n + j];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Direct areas of n zones in a closed scene with uniform exchange.
    fn uniform_exchange(n: usize) -> (Vec<f64>, Vec<f64>) {
        let c: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
        let all: f64 = c.iter().sum();
        let f = (0..n * n).map(|k| c[k / n] * c[k % n] / all).collect();
        (f, c)
    }

    // Guards (numbers): total exchange areas equal the series of all reflections and are symmetric to the bit.
    #[test]
    fn total_areas_are_the_series_of_all_reflections() {
        let n = 150;
        let (f, c) = uniform_exchange(n);
        let r: Vec<f64> = (0..n).map(|i| (i % 7) as f64 / 7.0).collect();
        let t = total_exchange_areas(&f, &vec![1e-9; n * n], &c, &r).unwrap();
        // Follow the emission of zone 5 through all reflections.
        let mut sent = vec![0.0; n];
        sent[5] = 1.0 - r[5];
        let mut taken = vec![0.0; n];
        for _ in 0..400 {
            let arrives: Vec<f64> = (0..n).map(|i| (0..n).map(|j| f[i * n + j] * sent[j]).sum()).collect();
            for i in 0..n {
                taken[i] += (1.0 - r[i]) * arrives[i];
                sent[i] = r[i] * arrives[i] / c[i];
            }
        }
        for i in 0..n {
            assert!((t.areas[i * n + 5] - taken[i]).abs() < 1e-12, "{i}");
            assert_eq!(t.areas[i * n + 5].to_bits(), t.areas[5 * n + i].to_bits());
            let row: f64 = t.areas[i * n..(i + 1) * n].iter().sum();
            assert!((row - (1.0 - r[i]) * c[i]).abs() < 1e-11, "{i}");
        }
        // An error of a factor within its radius stays within the radii of T.
        let mut g = f.clone();
        (g[3 * n + 40], g[40 * n + 3]) = (g[3 * n + 40] + 1e-9, g[40 * n + 3] + 1e-9);
        let u = total_exchange_areas(&g, &vec![0.0; n * n], &c, &r).unwrap();
        for k in 0..n * n {
            assert!((u.areas[k] - t.areas[k]).abs() <= t.radii[k] * (1.0 + 1e-6) + 1e-15);
        }
        let sums = sum_by_group(&t.areas, &vec![0; n], 1);
        let want: f64 = (0..n).map(|i| (1.0 - r[i]) * c[i]).sum();
        assert!((sums[0] - want).abs() < 1e-9);
    }

    #[test]
    fn perfect_symmetry_planes_have_no_total_areas() {
        let (f, c) = uniform_exchange(3);
        assert!(total_exchange_areas(&f, &[0.0; 9], &c, &[1.0; 3]).is_none());
    }
}
