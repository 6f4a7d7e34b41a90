//! Total exchange areas: what a zone emits, reflected and scattered any number of times, that another absorbs.
//!
//! With direct areas F_ij, c_i = A_i or 4κ_iV_i, r_i = ρ_i or Ω_i, a = 1 − r and D = diag(r/c), radiosities are B = a E + D P, arriving power is
//! P = F B, and zone i takes up a_i P_i. So zone i gives T_ij (E_i − E_j) watts to zone j on balance, E = σT⁴, with
//!
//! ```text
//!     T = a F (I − D F)⁻¹ a = a (F + XᵀX) a          LLᵀ = I − √D F √D,  L X = √D F
//! ```
//!
//! symmetric as it is computed; in a closed scene its rows sum to a_i c_i (Σ_j F_ij = c_i): ε A of a surface, 4κ_aV of a volume. No other decomposition is
//! needed: I − √D F √D is positive definite as long as some power is lost.
//!
//! **Errors.** To first order δT = Kᵀ δF K with K = (I + D (F + XᵀX)) a, which has no negative entry: radii of F go through it as bounds.
//!
//! Cost: about 4n³ multiplications, and 5n² numbers beside F and its radii.

use rayon::prelude::*;

/// Rows that a block of the loops holds.
const BLOCK: usize = 64;

/// Numbers a pair of zones beside F and its radii: T, its radii, and three matrices on the way.
pub const NUMBERS: u64 = 5;

/// T and its radii, m², row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Total {
    /// T_ij.
    pub areas: Vec<f64>,
    /// Error radii, by the radii of F.
    pub radii: Vec<f64>,
}

/// Σ_k a_ki b_kj over rows k: AᵀB, row by row of the result; the order of a sum does not depend on threads.
fn transposed_product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    out.par_chunks_mut(n * BLOCK).enumerate().for_each(|(block, rows)| {
        for k in 0..n {
            let from = &b[k * n..(k + 1) * n];
            for (i, row) in rows.chunks_mut(n).enumerate() {
                let x = a[k * n + block * BLOCK + i];
                if x != 0.0 {
                    row.iter_mut().zip(from).for_each(|(o, b)| *o += x * b);
                }
            }
        }
    });
    out
}

/// L of a symmetric matrix, in its lower half; false where it is not positive definite.
fn decomposed(m: &mut [f64], n: usize) -> bool {
    for from in (0..n).step_by(BLOCK) {
        let to = (from + BLOCK).min(n);
        // The block on the diagonal, row by row.
        for i in from..to {
            for j in from..=i {
                let sum: f64 = (from..j).map(|k| m[i * n + k] * m[j * n + k]).sum();
                let x = m[i * n + j] - sum;
                if i > j {
                    m[i * n + j] = x / m[j * n + j];
                } else if x > 0.0 {
                    m[i * n + i] = x.sqrt();
                } else {
                    return false;
                }
            }
        }
        let (done, rest) = m.split_at_mut(to * n);
        // The rows below, and what they take from the rest.
        rest.par_chunks_mut(n).for_each(|row| {
            for j in from..to {
                let own = &done[j * n..];
                let sum: f64 = (from..j).map(|k| row[k] * own[k]).sum();
                row[j] = (row[j] - sum) / own[j];
            }
        });
        let panel: Vec<f64> = rest.chunks(n).flat_map(|r| r[from..to].to_vec()).collect();
        let width = to - from;
        rest.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
            let own = &panel[i * width..(i + 1) * width];
            for (j, other) in panel.chunks(width).enumerate().take(i + 1) {
                let sum: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
                row[to + j] -= sum;
            }
        });
    }
    true
}

/// X of L X = B, in the place of B.
fn lower_solved(l: &[f64], b: &mut [f64], n: usize) {
    for from in (0..n).step_by(BLOCK) {
        let to = (from + BLOCK).min(n);
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
        rest.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
            for k in from..to {
                let x = l[(to + i) * n + k];
                row.iter_mut().zip(&done[k * n..(k + 1) * n]).for_each(|(r, d)| *r -= x * d);
            }
        });
    }
}

/// T of `n` zones from direct areas and their radii (m², row by row), c (m²) and r. None where no power is lost, so that there is no end to it.
pub fn total(areas: &[f64], radii: &[f64], c: &[f64], r: &[f64]) -> Option<Total> {
    let n = c.len();
    let root: Vec<f64> = c.iter().zip(r).map(|(c, r)| if *c > 0.0 { (r / c).sqrt() } else { 0.0 }).collect();
    let absorb: Vec<f64> = c.iter().zip(r).map(|(c, r)| if *c > 0.0 { 1.0 - r } else { 0.0 }).collect();
    if n == 0 {
        return Some(Total { areas: Vec::new(), radii: Vec::new() });
    }
    let mut l = vec![0.0; n * n];
    l.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        for (j, x) in row.iter_mut().enumerate() {
            *x = f64::from(u8::from(i == j)) - root[i] * areas[i * n + j] * root[j];
        }
    });
    if !decomposed(&mut l, n) {
        return None;
    }
    let mut x: Vec<f64> = areas.to_vec();
    x.par_chunks_mut(n).enumerate().for_each(|(i, row)| row.iter_mut().for_each(|v| *v *= root[i]));
    lower_solved(&l, &mut x, n);
    drop(l);
    // Y = F + XᵀX, of which both halves are the same sums in the same order.
    let mut y = transposed_product(&x, &x, n);
    drop(x);
    y.par_iter_mut().zip(areas).for_each(|(y, f)| *y += f);
    // K, column j times a_j.
    let mut k = vec![0.0; n * n];
    k.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        for (j, v) in row.iter_mut().enumerate() {
            *v = (f64::from(u8::from(i == j)) + root[i] * root[i] * y[i * n + j]) * absorb[j];
        }
    });
    let half = transposed_product(radii, &k, n);
    let radii = transposed_product(&half, &k, n);
    drop((half, k));
    y.par_chunks_mut(n).enumerate().for_each(|(i, row)| {
        row.iter_mut().zip(&absorb).for_each(|(v, a)| *v *= absorb[i] * a);
    });
    Some(Total { areas: y, radii })
}

/// Sums of a matrix over names: `group[i]` < `groups` is that of zone i; row by row.
pub fn by_group(matrix: &[f64], group: &[usize], groups: usize) -> Vec<f64> {
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

    /// Direct areas of n zones that see one another evenly, closed.
    fn even(n: usize) -> (Vec<f64>, Vec<f64>) {
        let c: Vec<f64> = (0..n).map(|i| 1.0 + 0.1 * i as f64).collect();
        let all: f64 = c.iter().sum();
        let f = (0..n * n).map(|k| c[k / n] * c[k % n] / all).collect();
        (f, c)
    }

    #[test]
    fn it_is_the_series_of_all_reflections() {
        let n = 150;
        let (f, c) = even(n);
        let r: Vec<f64> = (0..n).map(|i| (i % 7) as f64 / 7.0).collect();
        let t = total(&f, &vec![1e-9; n * n], &c, &r).unwrap();
        // What zone 5 emits: absorbed by all, after each reflection.
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
        // A factor that errs by its radius moves the answer by no more than its own.
        let mut g = f.clone();
        (g[3 * n + 40], g[40 * n + 3]) = (g[3 * n + 40] + 1e-9, g[40 * n + 3] + 1e-9);
        let u = total(&g, &vec![0.0; n * n], &c, &r).unwrap();
        for k in 0..n * n {
            assert!((u.areas[k] - t.areas[k]).abs() <= t.radii[k] * (1.0 + 1e-6) + 1e-15);
        }
        let sums = by_group(&t.areas, &vec![0; n], 1);
        let want: f64 = (0..n).map(|i| (1.0 - r[i]) * c[i]).sum();
        assert!((sums[0] - want).abs() < 1e-9);
    }

    #[test]
    fn mirrors_alone_have_no_answer() {
        let (f, c) = even(3);
        assert!(total(&f, &[0.0; 9], &c, &[1.0; 3]).is_none());
    }
}
