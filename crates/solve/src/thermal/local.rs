//! One zone's part in the thermal equations; see the header of [`super`].

use rayon::prelude::*;
use zonal_scene::thermal::black;
use zonal_scene::{Bands, Known, Scene, Shares, Thermal, Zones, bands};

/// Steps of the search for E.
const STEPS: usize = 200;

/// m, a, r and what is known of a zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// m: 1, or 4κ in 1/m.
    pub weight: Bands,
    /// a: 1 − ρ, or 1 − Ω.
    pub absorb: Bands,
    /// r: ρ, or Ω.
    pub reflect: Bands,
    /// T in K, or q in W/m² or W/m³; never the power of a whole surface.
    pub known: Known,
    /// A in m², V in m³.
    pub measure: f64,
    /// What h is of H or G: 1, or ¼.
    pub part: f64,
}

impl Local {
    /// m a, band by band.
    pub(super) fn uptake(&self) -> Bands {
        bands(|b| self.weight[b] * self.absorb[b])
    }
    /// Net power of a zone of black emissive power `e` that `h` arrives at, W/m² or W/m³.
    pub(super) fn net(&self, shares: &Shares, e: f64, h: Bands) -> f64 {
        let (w, m) = (shares.emissive(e)[0], self.uptake());
        shares.total(bands(|b| m[b] * (w[b] - h[b])))
    }
    /// E of a zone that gives `q` and that `h` arrives at, W/m²; none where it neither absorbs nor emits.
    pub(super) fn balanced(&self, shares: &Shares, q: f64, h: Bands) -> Option<f64> {
        let m = self.uptake();
        let own = |a: Bands| shares.total(bands(|b| m[b] * a[b]));
        if own([1.0; 3]) <= 0.0 {
            return None;
        }
        let wanted = q + own(h);
        if shares.is_constant() || wanted <= 0.0 {
            let a = own(shares.weights(0.0));
            return (a > 0.0).then(|| wanted / a);
        }
        // What is emitted grows with E: halve the interval that holds the answer.
        let emitted = |e: f64| own(shares.emissive(e)[0]);
        let most = m.iter().fold(0.0f64, |s, x| s.max(*x));
        let (mut low, mut high) = (0.0, wanted / most);
        for _ in 0..STEPS {
            if emitted(high) >= wanted {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if emitted(middle) < wanted { low = middle } else { high = middle }
        }
        Some(high)
    }
}

/// What the zones' own properties are, whatever they were posed as.
pub(super) struct Locals<'a> {
    scene: &'a Scene,
    pub thermal: &'a Thermal,
    /// Area of each surface's patches, m².
    areas: Vec<f64>,
}

impl<'a> Locals<'a> {
    /// Of the zones of a thermal scene.
    pub(super) fn new(scene: &'a Scene, zones: &Zones) -> Locals<'a> {
        let Some(thermal) = scene.thermal() else { unreachable!("asked of thermal scenes alone") };
        let mut areas = vec![0.0; scene.surfaces().len()];
        zones.patches.iter().for_each(|p| areas[p.surface] += p.area);
        Locals { scene, thermal, areas }
    }
    /// Zone `i`.
    pub(super) fn of(&self, zones: &Zones, i: usize) -> Local {
        if i < zones.voxel_offset() {
            let p = &zones.patches[i];
            let known = match self.thermal.surfaces[p.surface] {
                Known::Power(w) => Known::Flux(w / self.areas[p.surface]),
                known => known,
            };
            let reflect = self.scene.surfaces()[p.surface].reflectance;
            return Local {
                weight: [1.0; 3],
                absorb: reflect.map(|r| 1.0 - r),
                reflect,
                known,
                measure: p.area,
                part: 1.0,
            };
        }
        let (kappa, albedo, known) = if i < zones.pane_offset() {
            let cell = zones.voxels[i - zones.voxel_offset()].cell;
            // A scene has a voxmap wherever it has voxel zones.
            let map = self.scene.voxmap();
            let of = |f: &dyn Fn(&zonal_scene::Voxmap) -> Bands| map.map_or([0.0; 3], f);
            let known = map.and_then(|m| m.heat(cell)).unwrap_or(Known::Flux(0.0));
            (of(&|m| m.extinction(cell)), of(&|m| m.albedo(cell)), known)
        } else {
            let pane = zones.panes[i - zones.pane_offset()].pane;
            let p = &self.scene.panes()[pane];
            (p.extinction, p.albedo, self.thermal.panes[pane])
        };
        Local {
            weight: kappa.map(|k| 4.0 * k),
            absorb: albedo.map(|o| 1.0 - o),
            reflect: albedo,
            known,
            measure: zones.response(i).1,
            part: 0.25,
        }
    }
    /// What is known of zone `i`, and what it gives of itself in the linear equations: emitted flux or black emissive power of a known
    /// temperature, else the source q in each band by the shares of emission.
    pub(super) fn posed(&self, zones: &Zones, i: usize) -> (Known, Bands) {
        let (l, shares) = (self.of(zones, i), &self.thermal.shares);
        let own = match l.known {
            Known::Temperature(t) => {
                let w = shares.emissive(black(t))[0];
                if i < zones.voxel_offset() { bands(|b| l.absorb[b] * w[b]) } else { w }
            }
            Known::Flux(q) | Known::Power(q) if q != 0.0 => {
                let (a, m) = (shares.weights(self.level()), l.uptake());
                let all = shares.total(bands(|b| a[b] * m[b]));
                bands(|b| if all > 0.0 { q * a[b] * m[b] / all } else { 0.0 })
            }
            _ => [0.0; 3],
        };
        (l.known, own)
    }
    /// A temperature to begin with, K: the mean of those that surfaces and surroundings have, or that of the medium.
    pub(super) fn level(&self) -> f64 {
        let surfaces = self.thermal.surfaces.iter().chain(&self.thermal.panes);
        let mut list: Vec<f64> = surfaces.filter_map(|k| temperature_of(*k)).collect();
        list.extend(self.thermal.surroundings);
        if list.is_empty() {
            list.extend(self.scene.voxmap().and_then(|m| m.heat(0)).and_then(temperature_of));
        }
        let mean = list.iter().map(|t| black(*t)).sum::<f64>() / list.len().max(1) as f64;
        if list.is_empty() { 300.0 } else { zonal_scene::thermal::temperature(mean) }
    }
    /// All zones.
    pub(super) fn all(&self, zones: &Zones) -> Vec<Local> {
        (0..zones.len()).into_par_iter().map(|i| self.of(zones, i)).collect()
    }
}

fn temperature_of(known: Known) -> Option<f64> {
    if let Known::Temperature(t) = known { Some(t) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balanced_zone_gives_what_it_shall() {
        let shares = Shares::Weights {
            coefficients: [vec![0.2, 1e-4], vec![0.7, -1.5e-4], vec![0.1, 0.5e-4]],
            range: [300.0, 3000.0],
            left_out: false,
        };
        let l = Local {
            weight: [1.2, 0.0, 40.0],
            absorb: [0.9, 0.3, 0.5],
            reflect: [0.1, 0.7, 0.5],
            known: Known::Flux(0.0),
            measure: 1.0,
            part: 0.25,
        };
        for (q, h) in [(0.0, [1e4, 2e4, 5e3]), (5e4, [0.0; 3]), (-1e3, [1e5, 0.0, 3e4])] {
            let e = l.balanced(&shares, q, h).unwrap();
            assert!((l.net(&shares, e, h) - q).abs() < 1e-9 * (1e5 + q.abs()), "{q}");
        }
        let mirror = Local { absorb: [0.0; 3], ..l };
        assert_eq!(mirror.balanced(&shares, 0.0, [1.0; 3]), None);
    }
}
