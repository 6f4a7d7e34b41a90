//! The formula of each kind of pair, selected by [`Exchange::pair_in_row`].

use super::distance_moments::PLATE_ERROR_OVER_AREA;
use super::exchange::Exchange;
use super::pair_factor::{PairCounts, PairFactor};
use super::prepared_zone::{PreparedShape, PreparedZone, is_behind, prepared_plate};
use super::ray_average::{ZonePair, pane_self_exchange};
use super::volume_factors::{SelfAttenuation, VolumeFactorMethod, VoxelPair};
use crate::aligned::Cuboid;
use crate::pair::visibility::ray_samples::{PANE_EDGE_SPLITS, PANE_SPLITS, SMALL_TOLERANCE};
use crate::solid_angle_quadrature::DistanceMoments;
use zonal_math::{Bounded, Grade, low_discrepancy};
use zonal_scene::{Band, Bands};

/// A zone whose pairs are computed one after the other.
pub struct PairRow {
    i: usize,
    /// The factors that the formula for two voxels computes by rows: 𝓕 with every cell of the voxel grid, m⁴.
    factors: Vec<Bounded>,
}

impl Exchange<'_> {
    /// g_ij; symmetric to the bit.
    pub fn pair(&self, i: usize, j: usize, counts: &mut PairCounts) -> PairFactor {
        let (i, j) = if i < j { (j, i) } else { (i, j) };
        self.pair_in_row(&self.row(i), j, counts)
    }

    /// The work that all pairs of zone `i` with zones up to itself share.
    pub fn row(&self, i: usize) -> PairRow {
        let zone = self.prepared.get(i);
        let factors = match (self.settings.volume_factors, &zone.shape, &zone.aligned, self.voxel_grid) {
            (Some(method), PreparedShape::Voxel, Some(voxel), Some(grid)) => method.row(voxel, grid),
            _ => Vec::new(),
        };
        PairRow { i, factors }
    }

    /// g_ij of the row's zone i and j ≤ i.
    pub fn pair_in_row(&self, row: &PairRow, j: usize, counts: &mut PairCounts) -> PairFactor {
        let i = row.i;
        assert!(j <= i, "column {j} is above the diagonal of row {i}");
        if let Some(strips) = &self.strips {
            return strips.pair(i, j, counts);
        }
        let (a, b) = (&*self.prepared.get(i), &*self.prepared.get(j));
        if i == j {
            return self.self_exchange(i, counts);
        }
        if is_behind(a, b) || is_behind(b, a) {
            counts.facing_away += 1;
            return PairFactor::default();
        }
        let pair = ZonePair { a, b, seed: self.settings.seed(i, j), uniform: self.media.of_pair(a, b) };
        match (&a.shape, &b.shape) {
            (PreparedShape::CutVoxel(_), _) | (_, PreparedShape::CutVoxel(_)) => {
                counts.cut += 1;
                counts.estimated += 1;
                self.cut_voxel_pair(pair, counts)
            }
            (PreparedShape::Plate { pane: Some(_), .. }, _)
            | (_, PreparedShape::Plate { pane: Some(_), .. }) => {
                counts.pane += 1;
                counts.estimated += 1;
                self.pane_pair(pair, self.pane_splits(a, b), counts)
            }
            (PreparedShape::Voxel, PreparedShape::Voxel) => match self.settings.volume_factors {
                Some(method) => {
                    counts.by_volume_method += 1;
                    counts.estimated += 1;
                    let m = self.volume_method_moments(method, row, j);
                    self.attenuated(pair, m, pair.uniform, counts)
                }
                None => self.patch_or_voxel_pair(i, j, pair, counts),
            },
            _ => self.patch_or_voxel_pair(i, j, pair, counts),
        }
    }

    /// The factor of two voxels by `method`, all of it at the distance of the centres.
    fn volume_method_moments(
        &self,
        method: &dyn VolumeFactorMethod,
        row: &PairRow,
        j: usize,
    ) -> DistanceMoments {
        let (a, b) = (&*self.prepared.get(row.i), &*self.prepared.get(j));
        let distance = (a.centre - b.centre).length();
        let (Some(p), Some(q)) = (&a.aligned, &b.aligned) else { unreachable!("voxels are aligned") };
        let factor = method.factor(&VoxelPair {
            voxels: [p, q],
            volumes: [a.measure, b.measure],
            distance,
            row: &row.factors,
            cell: self.zones.voxels.at(j - self.zones.patches.len()).cell,
            exact: &self.cache,
        });
        DistanceMoments { factor, mean_distance: distance, ..DistanceMoments::ZERO }
    }

    /// Pairs of patches and whole voxels.
    fn patch_or_voxel_pair(&self, i: usize, j: usize, pair: ZonePair, counts: &mut PairCounts) -> PairFactor {
        let ZonePair { a, b, .. } = pair;
        if let (Some(p), Some(q)) = (&a.aligned, &b.aligned) {
            counts.aligned += 1;
            if let Some(kappa) = pair.uniform {
                let mut out = PairFactor::default();
                for band in Band::all() {
                    // Bands of one extinction have one factor.
                    let same = Band::all().take_while(|m| *m < band).find(|&m| kappa[m] == kappa[band]);
                    (out.value[band], out.radius[band]) = match same {
                        Some(same) => (out.value[same], out.radius[same]),
                        None => {
                            let f = self.aligned(p, q, kappa[band]);
                            (f.value, f.radius)
                        }
                    };
                }
                return self.visible(pair, out, counts);
            }
        } else {
            counts.general += 1;
            if matches!((&a.shape, &b.shape), (PreparedShape::Plate { .. }, PreparedShape::Plate { .. })) {
                return self.patch_pair(i, j, pair, counts);
            }
        }
        counts.estimated += u64::from(a.aligned.is_none() || b.aligned.is_none());
        let m = self.distance_moments(a, b);
        self.attenuated(pair, m, pair.uniform.filter(|_| !self.is_thick(a, b)), counts)
    }

    /// Two boxes or rectangles along the axes in a uniform medium, with all images of one of them.
    fn aligned(&self, p: &Cuboid, q: &Cuboid, kappa: f64) -> Bounded {
        match &self.images {
            Some(images) => images.sum(p, q, kappa),
            None => self.cache.get(p, q, kappa),
        }
    }

    /// Two patches, at least one in a general position: the factor is proved, the moments of its distance are estimated.
    fn patch_pair(&self, i: usize, j: usize, pair: ZonePair, counts: &mut PairCounts) -> PairFactor {
        let ZonePair { a, b, .. } = pair;
        let factor = self.plates.pair(i, j, self.settings.plate_tolerance, PLATE_ERROR_OVER_AREA).bounded;
        if pair.uniform != Some(Bands::ZERO) {
            let m = DistanceMoments { factor, ..self.distance_moments(a, b) };
            counts.estimated += 1;
            return self.attenuated(pair, m, pair.uniform.filter(|_| !self.is_thick(a, b)), counts);
        }
        counts.estimated += u64::from(factor.grade != Grade::Proved);
        let out = PairFactor { value: Bands::splat(factor.value), radius: Bands::splat(factor.radius) };
        self.visible(pair, out, counts)
    }

    /// A geometric factor with the attenuation of a `uniform` medium, or of the medium along rays.
    fn attenuated(
        &self,
        pair: ZonePair,
        m: DistanceMoments,
        uniform: Option<Bands>,
        counts: &mut PairCounts,
    ) -> PairFactor {
        match uniform {
            Some(kappa) => {
                let t = kappa.map(|k| m.transmittance(k));
                let out = PairFactor { value: m.factor.value * t, radius: m.factor.radius * t };
                self.visible(pair, out, counts)
            }
            None => self.attenuated_along_rays(pair, m, counts),
        }
    }

    /// Exchange of a zone with itself.
    fn self_exchange(&self, i: usize, counts: &mut PairCounts) -> PairFactor {
        let z = &*self.prepared.get(i);
        match &z.shape {
            PreparedShape::Plate { pane: None, .. } => PairFactor::default(),
            PreparedShape::Plate { pane: Some(k), .. } => {
                let p = &self.zones.panes[*k];
                let value = p
                    .extinction
                    .map(|k| if k > 0.0 { pane_self_exchange(k, p.thickness) * z.measure } else { 0.0 });
                PairFactor { value, radius: Bands::ZERO }
            }
            PreparedShape::Voxel => {
                let kappa = self.kappa(i);
                let c = z.aligned.as_ref().expect("a voxel is aligned");
                let at_centre = self
                    .settings
                    .volume_factors
                    .is_some_and(|m| m.self_attenuation() == SelfAttenuation::AtCentre);
                let f = kappa.map(|k| self.aligned(c, c, if at_centre { 0.0 } else { k }));
                let all = PairFactor { value: f.map(|f| f.value), radius: f.map(|f| f.radius) };
                self.visible_self_exchange(i, all, counts)
            }
            PreparedShape::CutVoxel(samples) => {
                counts.cut += 1;
                counts.estimated += 1;
                let m = self.subcell_sum([0; 3], samples, samples);
                let kappa = self.kappa(i);
                let value = m.factor.value * kappa.map(|k| m.transmittance(k));
                self.visible_self_exchange(i, PairFactor { value, radius: value * self.tolerance }, counts)
            }
        }
    }

    /// Multiplies the exchange `all` of zone `i` with itself by the visible fraction: a thin wall may stand in the middle of a voxel
    /// without dividing it.
    fn visible_self_exchange(&self, i: usize, all: PairFactor, counts: &mut PairCounts) -> PairFactor {
        let z = &*self.prepared.get(i);
        self.visible(
            ZonePair { a: z, b: z, seed: self.settings.seed(i, i), uniform: self.media.of_pair(z, z) },
            all,
            counts,
        )
    }

    /// A factor times the visible fraction where the scene has occluders.
    fn visible(&self, pair: ZonePair, all: PairFactor, counts: &mut PairCounts) -> PairFactor {
        if self.occlusion.has_occluders { self.times_visibility(pair, all, counts) } else { all }
    }

    /// Subdivisions of a pane and another zone close to it.
    fn pane_splits(&self, a: &PreparedZone, b: &PreparedZone) -> u32 {
        let plates = [a, b].iter().all(|z| matches!(z.shape, PreparedShape::Plate { .. }));
        if plates && self.tolerance < SMALL_TOLERANCE { PANE_EDGE_SPLITS } else { PANE_SPLITS }
    }

    /// A pane and any zone but a cut voxel. The larger plate of a close pair is divided into quarters: paths through the pane vary strongly
    /// at grazing angles.
    fn pane_pair(&self, pair: ZonePair, splits: u32, counts: &mut PairCounts) -> PairFactor {
        let ZonePair { a, b, seed, .. } = pair;
        let close = (a.centre - b.centre).length() < a.diameter.max(b.diameter);
        let first = matches!(a.shape, PreparedShape::Plate { .. })
            && (a.diameter >= b.diameter || !matches!(b.shape, PreparedShape::Plate { .. }));
        let (large, small) = if first { (a, b) } else { (b, a) };
        let PreparedShape::Plate { plate, pane } = &large.shape else {
            unreachable!("a pane is a plate");
        };
        if !close || splits == 0 {
            let m = self.distance_moments(a, b);
            return self.attenuated_along_rays(pair, m, counts);
        }
        let mut sum = PairFactor::default();
        for (k, quarter) in plate.quarters().into_iter().enumerate() {
            let part = prepared_plate(quarter, *pane);
            let seed = low_discrepancy::split_mix64(seed + k as u64);
            let f = self.pane_pair(ZonePair { a: &part, b: small, seed, ..pair }, splits - 1, counts);
            sum.value += f.value;
            sum.radius = sum.radius.hypot(f.radius);
        }
        sum
    }

    fn kappa(&self, i: usize) -> Bands {
        self.zones.voxels.at(i - self.zones.patches.len()).extinction
    }
}
