//! Temperatures and heat flows by name.

use crate::base::named_enum::named_enum;
/// The subject of a [`HeatRow`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeatRowKind {
    /// A named surface.
    Surface,
    /// All voxels.
    Medium,
    /// A named pane.
    Pane,
}

named_enum!(HeatRowKind: Surface "surface", Medium "medium", Pane "pane");

/// Temperature and net power of a named surface, of the medium or of a pane. Errors are sums of the moduli of the zones' estimated errors: of the
/// exchange, of direct light and of the solver. That of the finite zones is apart, in [`crate::DiscretizationError::heat`].
#[derive(Clone, Debug, PartialEq)]
pub struct HeatRow {
    /// Name.
    pub name: String,
    /// Subject.
    pub kind: HeatRowKind,
    /// Area of all patches, m²; volume of the medium or pane, m³.
    pub size: f64,
    /// (mean of T⁴ over area or volume)^¼ of the zones with a temperature, K; `None` if there are none.
    pub temperature: Option<f64>,
    /// Error of the temperature, K.
    pub temperature_error: Option<f64>,
    /// Net emitted power, W.
    pub power: f64,
    /// Error of the power, W.
    pub power_error: f64,
    /// Absorbed sunlight, W, which the net power contains with a negative sign; `None` in scenes without sunlight.
    pub absorbed_sunlight: Option<f64>,
}

impl HeatRow {
    /// Net power over size, W/m² of surfaces, W/m³ of media and panes, and its error.
    pub fn flux(&self) -> [f64; 2] {
        [self.over_size(self.power), self.over_size(self.power_error)]
    }
    /// Total errors of temperature (K, NaN without one), net flux (W/m², W/m³) and net power (W): of the exchange plus that of the finite zones,
    /// `discretization` in K and W. Infinite if either is unknown, so also without an estimate of the latter.
    pub fn errors(&self, discretization: Option<[f64; 2]>) -> [f64; 3] {
        let [kelvin, watts] = discretization.unwrap_or([f64::INFINITY; 2]);
        let power = self.power_error + watts;
        let flux = if power.is_finite() { self.over_size(power) } else { power };
        [self.temperature_error.map_or(f64::NAN, |e| e + kelvin), flux, power]
    }
    /// A power (W) over the size: W/m² or W/m³; 0 for size 0.
    pub fn over_size(&self, power: f64) -> f64 {
        if self.size > 0.0 { power / self.size } else { 0.0 }
    }
}

/// Temperature and heat flows of a node ([`crate::ThermalNetwork`]).
#[derive(Clone, Debug, PartialEq)]
pub struct NodeResult {
    /// Name.
    pub name: String,
    /// Temperature, K; NaN if it has none.
    pub temperature: f64,
    /// Error of the temperature, K; 0 if it is given.
    pub temperature_error: f64,
    /// Net power that its surfaces radiate, W.
    pub radiated: f64,
    /// Power that its surfaces give to the air, W.
    pub convected: f64,
    /// Power that it gives to other nodes, W.
    pub conducted: f64,
}

impl NodeResult {
    /// Power that is supplied to the node from outside of the scene, W: the sum of what it radiates, convects and conducts.
    pub fn supplied(&self) -> f64 {
        self.radiated + self.convected + self.conducted
    }
}

/// Temperatures and net powers by name, and their balance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatReport {
    /// Surfaces in the scene's order, then the medium, then panes.
    pub rows: Vec<HeatRow>,
    /// Nodes, in the order of the scene.
    pub nodes: Vec<NodeResult>,
    /// Power incoming from the surroundings minus power escaping to them, W.
    pub surroundings: f64,
    /// Power absorbed by the black, cold back faces of one-sided surfaces, W.
    pub absorbed_backfaces: f64,
    /// Power that emitting surfaces of light add, W: it is supplied to them beside their net powers.
    pub emitters: f64,
}

impl HeatReport {
    /// Sum of all net powers and of the power of emitters, 0 up to errors, W.
    ///
    /// ```
    /// use zonal_scene::HeatReport;
    /// let report = HeatReport { surroundings: 3.0, absorbed_backfaces: 2.0, ..HeatReport::default() };
    /// assert_eq!(report.balance(), 1.0);
    /// ```
    pub fn balance(&self) -> f64 {
        self.rows.iter().map(|r| r.power).sum::<f64>() + self.surroundings + self.emitters
            - self.absorbed_backfaces
    }
}
