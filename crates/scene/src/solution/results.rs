//! Results of a solution by name, with errors and units.

use crate::bands::band_set::BANDS_PER_BLOCK;
use crate::{Bands, ErrorEstimate, ErrorParts, HeatReport, HeatRowKind, Solution};

/// What one named surface emits, absorbs and gives.
///
/// An error is infinite where it is unknown.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceResult {
    /// Name of the surface.
    pub name: String,
    /// Area of the sides that exchange, m².
    pub area: f64,
    /// Net power that the surface gives, emitted less absorbed, all bands together, W.
    pub net_power: f64,
    /// Error of `net_power` by the exchange, direct light and the solver, W; the error of the finite zones is apart.
    pub exchange_error: f64,
    /// Error of `net_power` by the finite zones, W; none where it was not estimated.
    pub discretization_error: Option<f64>,
    /// Temperature, K: (mean of T⁴ over the area)^¼; none in light mode, and where none is defined.
    pub temperature: Option<f64>,
    /// Error of `temperature` by the exchange and the solver, K; the error of the finite zones is apart.
    pub temperature_exchange_error: Option<f64>,
    /// Error of `temperature` by the finite zones, K; none where it was not estimated.
    pub temperature_discretization_error: Option<f64>,
    /// Absorbed power in each band, W; in the first three of more bands.
    pub absorbed: Bands,
    /// Error of `absorbed` by the exchange, direct light and the solver, W.
    pub absorbed_error: Bands,
}

impl SurfaceResult {
    /// Net flux that leaves the surface, W/m²; 0 of a surface without area.
    #[must_use]
    pub fn net_flux(&self) -> f64 {
        if self.area > 0.0 { self.net_power / self.area } else { 0.0 }
    }

    /// The total error of `net_power`: of the exchange and of the finite zones, W; none where the latter was not estimated.
    #[must_use]
    pub fn total_error(&self) -> Option<f64> {
        self.discretization_error.map(|e| self.exchange_error + e)
    }
}

impl Solution {
    /// The named surfaces, in the order of the scene.
    #[must_use]
    pub fn surfaces(&self) -> Vec<SurfaceResult> {
        (0..self.scene.surfaces().len()).map(|i| self.surface_result(i)).collect()
    }

    /// The parts of the stated error of the patches, by the name "H" of their field, and of the volume zones and panes, by "G", the largest of all bands. Empty
    /// where the engine does not tell them apart.
    #[must_use]
    pub fn error_parts(&self) -> Vec<(&'static str, ErrorParts)> {
        let Some([patches, volumes]) =
            ErrorEstimate::largest_parts(self.blocks().map(|t| &t.report.estimate))
        else {
            return Vec::new();
        };
        let all = [
            ("H", patches, 0..self.zones.patches.len()),
            ("G", volumes, self.zones.patches.len()..self.zones.len()),
        ];
        all.into_iter()
            .filter(|(.., zones)| !zones.is_empty())
            .map(|(name, parts, _)| (name, parts))
            .collect()
    }

    /// The surface of this name, if there is one.
    #[must_use]
    pub fn surface(&self, name: &str) -> Option<SurfaceResult> {
        self.scene.surfaces().iter().position(|s| s.name == name).map(|i| self.surface_result(i))
    }

    fn surface_result(&self, index: usize) -> SurfaceResult {
        let report = &self.report;
        let by_name = |list: &[(String, Bands)]| list.get(index).map(|s| s.1);
        let error_by_name = |list: &[(String, Bands)]| by_name(list).unwrap_or(Bands::splat(f64::INFINITY));
        let absorbed = by_name(&report.energy.absorbed_surfaces).unwrap_or_default();
        let absorbed_error = error_by_name(&report.energy_error.absorbed_surfaces);
        let (area, emitted) = self.area_and_emitted_power(index);
        let zones = report.discretization_error.as_ref();
        let mut result = SurfaceResult {
            name: self.scene.surfaces()[index].name.clone(),
            area,
            net_power: (emitted - absorbed).sum(),
            exchange_error: absorbed_error.sum(),
            discretization_error: zones.map(|z| error_by_name(&z.energy.absorbed_surfaces).sum()),
            temperature: None,
            temperature_exchange_error: None,
            temperature_discretization_error: None,
            absorbed,
            absorbed_error,
        };
        let of_surface = |heat: &HeatReport| {
            let rows = heat.rows.iter().enumerate().filter(|(_, r)| r.kind == HeatRowKind::Surface);
            rows.map(|(k, r)| (k, r.clone())).nth(index)
        };
        if let Some((k, row)) = report.heat.as_ref().and_then(of_surface) {
            let of_zones = zones.and_then(|z| z.heat.get(k)).copied();
            result.net_power = row.power;
            result.exchange_error = row.power_error;
            result.discretization_error = of_zones.map(|e| e[1]);
            result.temperature = row.temperature;
            result.temperature_exchange_error = row.temperature_error;
            result.temperature_discretization_error = row.temperature.and(of_zones.map(|e| e[0]));
        } else {
            self.add_bands(index, &mut result);
        }
        result
    }

    /// Sums net power and its errors over the bands of the scene: without the values that fill up the last block, and with further blocks.
    fn add_bands(&self, index: usize, result: &mut SurfaceResult) {
        let total = |v: Bands| v.into_iter().take(self.scene.window().len()).sum::<f64>();
        if self.scene.window().len() < BANDS_PER_BLOCK {
            let report = &self.report;
            let of = |list: &[(String, Bands)]| list.get(index).map_or(f64::INFINITY, |s| total(s.1));
            let (_, emitted) = self.area_and_emitted_power(index);
            result.net_power = total(emitted - result.absorbed);
            result.exchange_error = of(&report.energy_error.absorbed_surfaces);
            let zones = report.discretization_error.as_ref();
            result.discretization_error = zones.map(|z| of(&z.energy.absorbed_surfaces));
        }
        for other in self.further_blocks.iter().map(|t| t.surface_result(index)) {
            result.net_power += other.net_power;
            result.exchange_error += other.exchange_error;
            result.discretization_error =
                result.discretization_error.zip(other.discretization_error).map(|(a, b)| a + b);
        }
    }

    /// Area of the patches of a surface, m², and what they emit, W per band; a direct emitter's emission is taken at the centre of each patch.
    fn area_and_emitted_power(&self, surface: usize) -> (f64, Bands) {
        let patches = self.zones.patches.iter().enumerate().filter(|(_, p)| p.surface == surface);
        patches.fold((0.0, Bands::ZERO), |(area, power), (i, p)| {
            (area + p.area, power + self.emitted_flux(i) * p.area)
        })
    }
}
