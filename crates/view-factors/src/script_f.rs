//! Hottel's total exchange areas ("script F") of grey diffuse surfaces without a medium.
//!
//! With exchange areas S and reflectances ρ = 1 − ε,
//!
//! ```text
//! M = diag(A_i/ρ_i) − S,     T_ij = (ε_i A_i/ρ_i) (ε_j A_j/ρ_j) (M⁻¹)_ij − δ_ij ε_i² A_i/ρ_i,     𝓕_ij = T_ij/A_i,     q_ij = T_ij σ (T_i⁴ − T_j⁴)
//! ```
//!
//! M is symmetric and diagonally dominant, with M⁻¹ ≥ 0. Errors ΔS of the exchange areas change T to first order by at most P ΔS Pᵀ with
//! P = diag(εA/ρ) M⁻¹. Dense Cholesky factorization: n³/3 operations for M, n³ for each of the two products.
//!
//! Reference: Hottel and Sarofim, Radiative Transfer, 1967, chapter 3.

use crate::ViewFactors;
use rayon::prelude::*;
use zonal_math::Bounded;
use zonal_math::parallel;
use zonal_scene::SceneError;

/// Largest number of surfaces: the matrices are dense.
const MAX_SURFACES: usize = 6_000;
/// Range of emissivities: black surfaces have no ρ⁻¹.
const EMISSIVITY_RANGE: [f64; 2] = [1e-3, 0.999];

/// Total exchange factors 𝓕, row by row.
#[derive(Clone, Debug)]
pub struct ScriptFactors {
    n: usize,
    values: Vec<f64>,
    radii: Vec<f64>,
}

impl ScriptFactors {
    /// 𝓕_ij with its error radius.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn get(&self, i: usize, j: usize) -> Bounded {
        assert!(i < self.n && j < self.n, "({i}, {j}) of {}", self.n);
        Bounded::estimated(self.values[i * self.n + j], self.radii[i * self.n + j])
    }
}

impl ViewFactors {
    /// The total exchange factors for emissivities, each taken as at least 0.001 and at most 0.999.
    ///
    /// # Errors
    /// Another number of emissivities than surfaces, emissivities outside 0 to 1, more than 6,000 surfaces, a surface without an area.
    pub fn script_factors(&self, emissivities: &[f64]) -> Result<ScriptFactors, SceneError> {
        let n = self.len();
        if emissivities.len() != n || emissivities.iter().any(|e| !(0.0..=1.0).contains(e)) {
            return Err(SceneError::new(
                "emissivity",
                format!("give {n} emissivities from 0 to 1, one for each surface"),
            ));
        }
        if n > MAX_SURFACES {
            let message = format!(
                "total exchange factors of {n} surfaces need dense matrices; give at most {MAX_SURFACES} surfaces"
            );
            return Err(SceneError::new("emissivity", message));
        }
        if self.areas().iter().any(|a| *a <= 0.0) {
            return Err(SceneError::new("facets", "a surface has no area; leave it out"));
        }
        let bounded = |e: &f64| e.clamp(EMISSIVITY_RANGE[0], EMISSIVITY_RANGE[1]);
        let emissivity: Vec<f64> = emissivities.iter().map(bounded).collect();
        let over_rho: Vec<f64> = (0..n).map(|i| self.areas()[i] / (1.0 - emissivity[i])).collect();
        let (mut system, mut errors) = (vec![0.0; n * n], vec![0.0; n * n]);
        for i in 0..n {
            for (j, b) in self.row(i) {
                system[i * n + j] = -b.value * self.areas()[i];
                errors[i * n + j] = b.radius * self.areas()[i];
            }
            system[i * n + i] += over_rho[i];
        }
        let inverse = inverse_of_symmetric(&system, n)?;
        let weight = |i: usize| emissivity[i] * over_rho[i];
        let scaled: Vec<f64> = (0..n * n).map(|k| weight(k / n) * inverse[k]).collect();
        let spread = product(&product(&scaled, &errors, n), &transposed(&scaled, n), n);
        let values = (0..n * n).map(|k| {
            let (i, j) = (k / n, k % n);
            let own = if i == j { emissivity[i] * emissivity[i] * over_rho[i] } else { 0.0 };
            (scaled[k] * weight(j) - own) / self.areas()[i]
        });
        let radii = (0..n * n).map(|k| spread[k] / self.areas()[k / n]);
        Ok(ScriptFactors { n, values: values.collect(), radii: radii.collect() })
    }
}

fn transposed(a: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|k| a[k % n * n + k / n]).collect()
}

fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let row = |i: usize| {
        let mut sum = vec![0.0; n];
        for k in 0..n {
            let x = a[i * n + k];
            if x != 0.0 {
                sum.iter_mut().zip(&b[k * n..(k + 1) * n]).for_each(|(s, y)| *s += x * y);
            }
        }
        sum
    };
    (0..n).into_par_iter().map(row).collect::<Vec<_>>().concat()
}

/// The inverse of a symmetric positive definite matrix by its Cholesky factor.
fn inverse_of_symmetric(a: &[f64], n: usize) -> Result<Vec<f64>, SceneError> {
    let mut l = a.to_vec();
    for j in 0..n {
        let pivot = l[j * n + j] - (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(SceneError::new(
                "emissivity",
                "the rows of the view factors exceed one; compute them with closing",
            ));
        }
        l[j * n + j] = pivot.sqrt();
        let (above, below) = l.split_at_mut((j + 1) * n);
        let row = &above[j * n..j * n + j];
        let diagonal = above[j * n + j];
        parallel::chunks(below, n, |_, r| {
            let sum: f64 = r[..j].iter().zip(row).map(|(x, y)| x * y).sum();
            r[j] = (r[j] - sum) / diagonal;
        });
    }
    let column = |c: usize| {
        let mut x = vec![0.0; n];
        for i in c..n {
            let sum: f64 = (c..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (f64::from(u8::from(i == c)) - sum) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - sum) / l[i * n + i];
        }
        x
    };
    Ok((0..n).into_par_iter().map(column).collect::<Vec<_>>().concat())
}

#[cfg(test)]
mod tests {
    use crate::{ConvexPolygon, FacetSet, ViewFactorSettings};
    use zonal_math::vec3;
    use zonal_scene::{NoCheckpoints, NoProgress};

    #[test]
    fn two_parallel_plates_exchange_as_in_closed_form() {
        // Plates 1 m wide at a distance of 1 mm: 𝓕 → 1/(1/ε₁ + 1/ε₂ − 1), to the share that leaves through the gap.
        let square = |z: f64, turn: [usize; 4]| {
            let c = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            turn.map(|k| vec3(c[k][0], c[k][1], z))
        };
        let mut set = FacetSet::new();
        set.add_surface(&square(0.0, [0, 1, 2, 3]));
        set.add_surface(&square(1e-3, [3, 2, 1, 0]));
        let settings = ViewFactorSettings { tolerance: 1e-6, ..Default::default() };
        let f = set.compute(&settings, &NoProgress, &NoCheckpoints).expect("valid settings");
        let script = f.script_factors(&[0.8, 0.3]).expect("two emissivities");
        let exact = 1.0 / (1.0 / 0.8 + 1.0 / 0.3 - 1.0);
        assert!((script.get(0, 1).value - exact).abs() < 5e-3, "{:?} {exact}", script.get(0, 1));
        assert!((script.get(0, 1).value - script.get(1, 0).value).abs() < 1e-12);
        assert!(script.get(0, 1).radius < 1e-5);
        assert!(f.script_factors(&[0.8]).is_err() && f.script_factors(&[0.8, 1.5]).is_err());
    }

    #[test]
    fn rows_of_an_enclosure_sum_to_the_emissivity() {
        let mut set = FacetSet::new();
        let corner = |k: usize| vec3((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]] {
            let p = ConvexPolygon::new(face.map(corner).to_vec()).expect("a square");
            set.add_parts(vec![p]);
        }
        let f =
            set.compute(&ViewFactorSettings::default(), &NoProgress, &NoCheckpoints).expect("valid settings");
        let emissivity = [0.1, 0.3, 0.5, 0.7, 0.9, 0.6];
        let script = f.script_factors(&emissivity).expect("six emissivities");
        for (i, e) in emissivity.iter().enumerate() {
            let sum: f64 = (0..6).map(|j| script.get(i, j).value).sum();
            assert!((sum - e).abs() < 1e-9, "{i}: {sum} {e}");
        }
    }
}
