//! The grey gases of a state.

/// One grey gas of a mixture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GreyGas {
    /// Absorption coefficient κ, 1/m.
    pub absorption: f64,
    /// Weight a: fraction of the black-body emissive power.
    pub weight: f64,
}

/// The grey gases of a state; a clear gas is the first. The weights sum to one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GreyGasMixture {
    /// The gases.
    pub gases: Vec<GreyGas>,
    /// Where the state is outside the range of the model, and what was used instead; one sentence each.
    pub notes: Vec<String>,
}

impl GreyGasMixture {
    /// Total emissivity of a uniform path of this length, m: Σ a_j (1 − e^{−κ_j L}).
    ///
    /// ```
    /// use zonal_gas::{GreyGas, GreyGasMixture};
    /// let gases = vec![GreyGas { absorption: 0.0, weight: 0.5 }, GreyGas { absorption: 2.0, weight: 0.5 }];
    /// let mixture = GreyGasMixture { gases, notes: Vec::new() };
    /// assert_eq!(mixture.emissivity(0.0), 0.0);
    /// assert_eq!(mixture.emissivity(f64::INFINITY), 0.5);
    /// ```
    pub fn emissivity(&self, length: f64) -> f64 {
        let term = |g: &GreyGas| {
            if g.absorption > 0.0 { -(-g.absorption * length).exp_m1() * g.weight } else { 0.0 }
        };
        self.gases.iter().map(term).sum()
    }
    /// Planck-mean absorption coefficient Σ a_j κ_j, 1/m.
    pub fn planck_mean(&self) -> f64 {
        self.gases.iter().map(|g| g.weight * g.absorption).sum()
    }
}
