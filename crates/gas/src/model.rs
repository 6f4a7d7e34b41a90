//! Gas models: names, sources, evaluation.

use crate::fit::{FittedGas, GreyGasFit};
use crate::mixture::GreyGasMixture;
use crate::state::{GasState, GasStateError, TEMPERATURES};
use crate::{bordbar, cassol, dorigon, kangwanpongpan, smith};

/// Absorption coefficient of soot divided by volume fraction and temperature, 1/(m K): 36π n k/((n² − k² + 2)² + 4 n² k²) · 3.72/(0.014388 m K)
/// with the refractive index 1.75 + 1.03 i of Williams, Shaddix, Jensen and Suo-Anttila 2007.
const SOOT_ABSORPTION: f64 = 1817.0;

/// A model of the radiative properties of a gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GasModel {
    /// `wsgg-smith-1982`: H2O and CO2, three grey gases, 600 to 2400 K.
    Smith1982,
    /// `wsgg-kangwanpongpan-2012`: H2O and CO2 of oxy-fuel combustion, four grey gases, 400 to 2500 K.
    Kangwanpongpan2012,
    /// `wsgg-dorigon-2013`: H2O and CO2 at the mole ratios 1 and 2, four grey gases, 400 to 2500 K.
    Dorigon2013,
    /// `wsgg-bordbar-2014`: H2O and CO2, mole ratios 0.01 to 4, four grey gases, 300 to 2400 K.
    Bordbar2014,
    /// `wsgg-bordbar-2020`: the set of 2014 with the pure gases.
    Bordbar2020,
    /// `wsgg-cassol-2014`: superposition of H2O, CO2 and soot, 25 gases, 50 with soot, 400 to 2500 K.
    Cassol2014,
    /// `grey-soot`: soot alone, one grey gas.
    GreySoot,
}

impl GasModel {
    /// All models.
    pub const VARIANTS: [GasModel; 7] = [
        GasModel::Smith1982,
        GasModel::Kangwanpongpan2012,
        GasModel::Dorigon2013,
        GasModel::Bordbar2014,
        GasModel::Bordbar2020,
        GasModel::Cassol2014,
        GasModel::GreySoot,
    ];

    /// Name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            GasModel::Smith1982 => "wsgg-smith-1982",
            GasModel::Kangwanpongpan2012 => "wsgg-kangwanpongpan-2012",
            GasModel::Dorigon2013 => "wsgg-dorigon-2013",
            GasModel::Bordbar2014 => "wsgg-bordbar-2014",
            GasModel::Bordbar2020 => "wsgg-bordbar-2020",
            GasModel::Cassol2014 => "wsgg-cassol-2014",
            GasModel::GreySoot => "grey-soot",
        }
    }
    /// The model of this name.
    ///
    /// ```
    /// use zonal_gas::GasModel;
    /// assert_eq!(GasModel::from_name("wsgg-smith-1982"), Some(GasModel::Smith1982));
    /// assert_eq!(GasModel::from_name("smith"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<GasModel> {
        GasModel::VARIANTS.into_iter().find(|m| m.name() == name)
    }
    /// The publication with the coefficients.
    pub fn source(self) -> &'static str {
        match self {
            GasModel::Smith1982 => "Smith, Shen, Friedman: J. Heat Transfer 104 (1982) 602-608",
            GasModel::Kangwanpongpan2012 => {
                "Kangwanpongpan et al.: Int. J. Heat Mass Transfer 55 (2012) 7419-7433"
            }
            GasModel::Dorigon2013 => "Dorigon et al.: Int. J. Heat Mass Transfer 64 (2013) 863-873",
            GasModel::Bordbar2014 => "Bordbar, Wecel, Hyppanen: Combustion and Flame 161 (2014) 2435-2445",
            GasModel::Bordbar2020 => {
                "Bordbar, Fraga, Hostikka: Int. Comm. Heat Mass Transfer 110 (2020) 104400"
            }
            GasModel::Cassol2014 => "Cassol et al.: Int. J. Heat Mass Transfer 79 (2014) 796-806",
            GasModel::GreySoot => "Williams et al.: Int. J. Heat Mass Transfer 50 (2007) 1616-1630",
        }
    }
    /// How the coefficients were checked.
    pub fn verification(self) -> &'static str {
        match self {
            GasModel::Smith1982 => {
                "two public implementations agree, except water vapour at 1 atm, for which only one is available"
            }
            GasModel::Kangwanpongpan2012 => "copied from one public implementation",
            GasModel::Dorigon2013 => {
                "two public implementations agree for the mole ratio 2; only one is available for the mole ratio 1"
            }
            GasModel::Bordbar2014 => "two public implementations agree to seven decimals",
            GasModel::Bordbar2020 => {
                "two public implementations agree to seven decimals; the emissivities match RadLib"
            }
            GasModel::Cassol2014 => {
                "copied from one public implementation; the emissivities match stated ones; two implementations agree for soot"
            }
            GasModel::GreySoot => "copied from one public implementation",
        }
    }
    /// Number of grey gases with the clear one, for a composition with soot or without.
    pub fn gas_count(self, has_soot: bool) -> usize {
        match self {
            GasModel::Smith1982 => 4,
            GasModel::Kangwanpongpan2012
            | GasModel::Dorigon2013
            | GasModel::Bordbar2014
            | GasModel::Bordbar2020 => 5,
            GasModel::Cassol2014 if has_soot => 50,
            GasModel::Cassol2014 => 25,
            GasModel::GreySoot => 1,
        }
    }
    /// The grey gases of a composition as functions of the temperature; that of the state is not used.
    ///
    /// # Errors
    /// If a property of the state is out of its physical range. Compositions outside the range of the model's fit add notes.
    pub fn fit(self, state: &GasState) -> Result<GreyGasFit, GasStateError> {
        state.check()?;
        let mut fit = match self {
            GasModel::Smith1982 => smith::fit(state),
            GasModel::Kangwanpongpan2012 => kangwanpongpan::fit(state),
            GasModel::Dorigon2013 => dorigon::fit(state),
            GasModel::Bordbar2014 => bordbar::fit_2014(state),
            GasModel::Bordbar2020 => bordbar::fit_2020(state),
            GasModel::Cassol2014 => return Ok(cassol::fit(state)),
            GasModel::GreySoot => {
                let gases = vec![FittedGas::new(0.0, vec![1.0])];
                GreyGasFit { gases, temperature_range: TEMPERATURES, notes: Vec::new() }
            }
        };
        fit.add_soot(SOOT_ABSORPTION * state.soot);
        Ok(fit)
    }
    /// Evaluates the model at a state.
    ///
    /// # Errors
    /// If a property of the state is out of its physical range. States outside the range of the model's fit add notes.
    pub fn evaluate(self, state: &GasState) -> Result<GreyGasMixture, GasStateError> {
        Ok(self.fit(state)?.at(state.temperature))
    }
}
