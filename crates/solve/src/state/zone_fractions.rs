//! Emissive powers w_b(E) of every zone in every band: the band fractions of the scene, or those of the gas of a cell.

use zonal_scene::{Band, BandFractions, Scene, SceneError, Thermal};

/// The fraction of the emission in each band, for each kind of zone.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneFractions {
    /// The fractions of every block of bands, for each kind; the first kind is that of the scene and of its surroundings.
    pub kinds: Vec<Vec<BandFractions>>,
    /// The kind of each zone; empty if all have the first.
    pub kind_of_zone: Vec<usize>,
}

impl Default for ZoneFractions {
    /// A grey scene.
    fn default() -> ZoneFractions {
        ZoneFractions { kinds: vec![vec![BandFractions::Grey]], kind_of_zone: Vec::new() }
    }
}

impl ZoneFractions {
    /// Of a scene in thermal mode, with the kind of each zone as an index into [`Thermal::all_fractions`].
    pub(super) fn of(scene: &Scene, kind_of_zone: Vec<usize>) -> ZoneFractions {
        let blocks: Vec<Scene> = scene.blocks().collect();
        let thermal: Vec<&Thermal> = blocks.iter().filter_map(Scene::thermal).collect();
        let count = thermal.first().map_or(0, |t| t.all_fractions().count());
        let kind = |k: usize| thermal.iter().filter_map(|t| t.all_fractions().nth(k).cloned()).collect();
        let is_uniform = kind_of_zone.iter().all(|k| *k == 0);
        if is_uniform {
            ZoneFractions { kinds: vec![kind(0)], kind_of_zone: Vec::new() }
        } else {
            ZoneFractions { kinds: (0..count).map(kind).collect(), kind_of_zone }
        }
    }

    /// True if every band holds the whole emission.
    #[must_use]
    pub fn is_grey(&self) -> bool {
        self.kinds.iter().flatten().any(BandFractions::is_grey)
    }

    /// The kind of a zone.
    #[must_use]
    pub fn kind(&self, zone: usize) -> usize {
        self.kind_of_zone.get(zone).copied().unwrap_or(0)
    }

    /// w_b and dw_b/dE of the first `bands` bands for a kind of zone with the black emissive power `e`, W/m².
    #[must_use]
    pub fn emissive_powers(&self, kind: usize, e: f64, bands: usize) -> Vec<[f64; 2]> {
        let of_block = |f: &BandFractions| {
            let [w, slope] = f.emissive_powers(e);
            let pairs: Vec<[f64; 2]> = w.into_iter().zip(slope).map(|(w, s)| [w, s]).collect();
            pairs
        };
        self.kinds[kind].iter().flat_map(of_block).take(bands).collect()
    }

    /// For each of the first `bands` bands, whether some zone emits in it at some temperature.
    pub(super) fn emitting(&self, bands: usize) -> Vec<bool> {
        let mut out = vec![false; bands];
        for kind in &self.kinds {
            let own = kind.iter().flat_map(|f| {
                let emitting = f.emitting_bands();
                Band::all().map(move |b| emitting[b])
            });
            out.iter_mut().zip(own).for_each(|(o, e)| *o |= e);
        }
        out
    }

    /// Refuses kinds without fractions for `bands` bands, fractions that are not valid, and kinds that do not exist.
    ///
    /// # Errors
    /// The name of the array.
    pub(super) fn check(&self, zones: usize, bands: usize) -> Result<(), SceneError> {
        let wrong = |name: &str| {
            let what = "the band fractions do not fit the zones and bands; write the exchange areas again";
            Err(SceneError::new(name, what))
        };
        let blocks = if self.is_grey() { 1 } else { bands.div_ceil(Band::count()) };
        if self.kinds.is_empty() || self.kinds.iter().any(|k| k.len() != blocks) {
            return wrong("band_fractions");
        }
        if self.is_grey() && (bands != 1 || self.kinds.len() != 1) {
            return wrong("band_fractions");
        }
        let is_known = self.kind_of_zone.iter().all(|k| *k < self.kinds.len());
        if !(self.kind_of_zone.is_empty() || self.kind_of_zone.len() == zones) || !is_known {
            return wrong("zone_fractions");
        }
        self.kinds.iter().try_for_each(|k| BandFractions::check_block_sums(k))
    }
}
