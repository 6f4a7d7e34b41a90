//! Coefficients and balance of one zone in the thermal equations (header of [`super`]).

use rayon::prelude::*;
use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{BandFractions, Bands, Fields, Scene, Thermal, ThermalCondition, Zones};

/// Maximum number of bracketing steps and of bisections for E.
const MAX_BISECTIONS: usize = 200;

/// Coefficients m, a, r of a zone and its thermal condition.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneBalance {
    /// m: 1, or 4κ in 1/m.
    pub weight: Bands,
    /// a: 1 − ρ, or 1 − Ω.
    pub absorb: Bands,
    /// r: ρ, or Ω.
    pub reflect: Bands,
    /// T in K, or q in W/m² or W/m³; never the power of a whole surface.
    pub condition: ThermalCondition,
    /// A in m², V in m³.
    pub measure: f64,
    /// h over H or G: 1, or ¼.
    pub incident_share: f64,
}

impl ZoneBalance {
    /// m a in each band.
    pub(super) fn absorption_weight(&self) -> Bands {
        self.weight * self.absorb
    }
    /// Net power of a zone with black emissive power `e` and incident flux `h`, W/m² or W/m³.
    pub(super) fn net_power(&self, fractions: &BandFractions, e: f64, h: Bands) -> f64 {
        let (w, m) = (fractions.emissive_powers(e)[0], self.absorption_weight());
        fractions.total(m * (w - h))
    }
    /// E of a zone with net power `q` and incident flux `h`, W/m², by bisection; `None` if it neither absorbs nor emits.
    pub(super) fn emissive_power_in_balance(
        &self,
        fractions: &BandFractions,
        q: f64,
        h: Bands,
    ) -> Option<f64> {
        let m = self.absorption_weight();
        let sum = |a: Bands| fractions.total(m * a);
        if sum(Bands::ONE) <= 0.0 {
            return None;
        }
        let wanted = q + sum(h);
        if fractions.is_constant() || wanted <= 0.0 {
            let a = sum(fractions.grey_gas_weights(0.0));
            return (a > 0.0).then(|| wanted / a);
        }
        // The emitted power increases with E: bracket the solution, then bisect.
        let emitted = |e: f64| sum(fractions.emissive_powers(e)[0]);
        let most = m.iter().fold(0.0f64, |s, x| s.max(*x));
        let (mut low, mut high) = (0.0, wanted / most);
        for _ in 0..MAX_BISECTIONS {
            if emitted(high) >= wanted {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..MAX_BISECTIONS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if emitted(middle) < wanted { low = middle } else { high = middle }
        }
        Some(high)
    }
    /// h of zone `i`, W/m².
    pub(super) fn incident_flux(&self, fields: &Fields, i: usize) -> Bands {
        self.incident_share * (fields.incident[i] + fields.direct[i])
    }
    /// E (W/m²) and q (W/m² or W/m³) of the zone for an incident flux `h`; E is NaN if undefined.
    pub(super) fn emissive_and_net_power(&self, fractions: &BandFractions, h: Bands) -> (f64, f64) {
        match self.condition {
            ThermalCondition::Temperature(t) => {
                let e = blackbody_emissive_power(t);
                (e, self.net_power(fractions, e, h))
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                (self.emissive_power_in_balance(fractions, q, h).unwrap_or(f64::NAN), q)
            }
        }
    }
}

/// Coefficients of all zones of a thermal scene by its own optical properties.
pub(super) struct ZoneBalances<'a> {
    scene: &'a Scene,
    pub thermal: &'a Thermal,
    /// Area of each surface's patches, m².
    areas: Vec<f64>,
    /// Area of each face's patches, m²; empty where no face has a power.
    face_areas: Vec<f64>,
}

impl<'a> ZoneBalances<'a> {
    /// Of the zones of a scene in thermal mode.
    pub(super) fn new(scene: &'a Scene, zones: &Zones) -> ZoneBalances<'a> {
        let Some(thermal) = scene.thermal() else { unreachable!("only called in thermal mode") };
        let mut areas = vec![0.0; scene.surfaces().len()];
        zones.patches.iter().for_each(|p| areas[p.surface] += p.area);
        let faces = scene.faces();
        let has_power = faces.values.iter().any(|v| matches!(v.condition, Some(ThermalCondition::Power(_))));
        let mut face_areas = vec![0.0; if has_power { faces.len() } else { 0 }];
        for p in zones.patches.iter().filter(|_| has_power) {
            faces.face_of(p.facet).into_iter().for_each(|f| face_areas[f] += p.area);
        }
        ZoneBalances { scene, thermal, areas, face_areas }
    }
    /// Area of the patches of a facet's face, m².
    fn face_area(&self, facet: usize) -> f64 {
        self.scene.faces().face_of(facet).map_or(f64::INFINITY, |f| self.face_areas[f])
    }
    /// Zone `i`.
    pub(super) fn of(&self, zones: &Zones, i: usize) -> ZoneBalance {
        if i < zones.voxel_offset() {
            let p = &zones.patches[i];
            let known = match self.scene.faces().values_of(p.facet).condition {
                Some(ThermalCondition::Power(w)) => ThermalCondition::Flux(w / self.face_area(p.facet)),
                Some(own) => own,
                None => match self.thermal.surfaces[p.surface] {
                    ThermalCondition::Power(w) => ThermalCondition::Flux(w / self.areas[p.surface]),
                    known => known,
                },
            };
            let reflect = self.scene.facet_reflectance(p.facet);
            return ZoneBalance {
                weight: Bands::ONE,
                absorb: 1.0 - reflect,
                reflect,
                condition: known,
                measure: p.area,
                incident_share: 1.0,
            };
        }
        let (kappa, albedo, known) = if i < zones.pane_offset() {
            let cell = zones.voxels[i - zones.voxel_offset()].cell;
            // A scene with voxel zones has a voxel grid.
            let map = self.scene.voxel_grid();
            let of = |f: &dyn Fn(&zonal_scene::VoxelGrid) -> Bands| map.map_or(Bands::ZERO, f);
            let known = map.and_then(|m| m.heat(cell)).unwrap_or(ThermalCondition::Flux(0.0));
            (of(&|m| m.extinction(cell)), of(&|m| m.albedo(cell)), known)
        } else {
            let pane = zones.panes[i - zones.pane_offset()].pane;
            let p = &self.scene.panes()[pane];
            (p.extinction, p.albedo, self.thermal.panes[pane])
        };
        ZoneBalance {
            weight: 4.0 * kappa,
            absorb: 1.0 - albedo,
            reflect: albedo,
            condition: known,
            measure: zones.response(i).1,
            incident_share: 0.25,
        }
    }
    /// Thermal condition of zone `i`, and its source in the linear equations: emitted flux or black emissive power for a known temperature, else the
    /// source q in each band by the band fractions.
    pub(super) fn source(&self, zones: &Zones, i: usize) -> (ThermalCondition, Bands) {
        let (l, fractions) = (self.of(zones, i), &self.thermal.band_fractions);
        let own = match l.condition {
            ThermalCondition::Temperature(t) => {
                let w = fractions.emissive_powers(blackbody_emissive_power(t))[0];
                if i < zones.voxel_offset() { l.absorb * w } else { w }
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) if q != 0.0 => {
                let (a, m) = (fractions.grey_gas_weights(self.initial_temperature()), l.absorption_weight());
                let all = fractions.total(a * m);
                if all > 0.0 { q * a * m / all } else { Bands::ZERO }
            }
            _ => Bands::ZERO,
        };
        (l.condition, own)
    }
    /// Initial temperature, K: the mean of the known temperatures of surfaces and surroundings, or that of the medium.
    pub(super) fn initial_temperature(&self) -> f64 {
        let surfaces = self.thermal.surfaces.iter().chain(&self.thermal.panes);
        let mut list: Vec<f64> = surfaces.filter_map(|k| temperature_of(*k)).collect();
        list.extend(self.thermal.surroundings);
        if list.is_empty() {
            list.extend(self.scene.voxel_grid().and_then(|m| m.heat(0)).and_then(temperature_of));
        }
        let mean = list.iter().map(|t| blackbody_emissive_power(*t)).sum::<f64>() / list.len().max(1) as f64;
        if list.is_empty() { 300.0 } else { blackbody_temperature(mean) }
    }
    /// All zones.
    pub(super) fn all(&self, zones: &Zones) -> Vec<ZoneBalance> {
        (0..zones.len()).into_par_iter().map(|i| self.of(zones, i)).collect()
    }
}

fn temperature_of(known: ThermalCondition) -> Option<f64> {
    if let ThermalCondition::Temperature(t) = known { Some(t) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_scene::PerBand;

    #[test]
    fn zone_in_balance_has_the_given_net_power() {
        let fractions = BandFractions::GreyGases {
            coefficients: PerBand::from_rgb([vec![0.2, 1e-4], vec![0.7, -1.5e-4], vec![0.1, 0.5e-4]]),
            range: [300.0, 3000.0],
            allow_partial: false,
        };
        let l = ZoneBalance {
            weight: Bands::from_rgb([1.2, 0.0, 40.0]),
            absorb: Bands::from_rgb([0.9, 0.3, 0.5]),
            reflect: Bands::from_rgb([0.1, 0.7, 0.5]),
            condition: ThermalCondition::Flux(0.0),
            measure: 1.0,
            incident_share: 0.25,
        };
        for (q, h) in [(0.0, [1e4, 2e4, 5e3]), (5e4, [0.0; 3]), (-1e3, [1e5, 0.0, 3e4])] {
            let h = Bands::from_rgb(h);
            let e = l.emissive_power_in_balance(&fractions, q, h).unwrap();
            assert!((l.net_power(&fractions, e, h) - q).abs() < 1e-9 * (1e5 + q.abs()), "{q}");
        }
        let mirror = ZoneBalance { absorb: Bands::ZERO, ..l };
        assert_eq!(mirror.emissive_power_in_balance(&fractions, 0.0, Bands::ONE), None);
    }
}
