//! A solution against a reference.

use super::halves::{HalvedValue, TotalError, ZoneWeight, median_ratio, share_within};
use super::reference::{Reference, ReferenceField, ReferenceZone};
use crate::harness::Error;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, LightGroupKind, Solution, ZoneKind};
use zonal_solve::relight::relight;

/// Factors on each light group in the check of relighting.
const RELIGHT_FACTORS: [f64; 2] = [0.0, 10.0];
/// Largest number of zones for which relit solutions are compared: each is a copy of the solution.
const MAX_RELIT_ZONES: usize = 300_000;
/// Largest relative difference of the sizes of equal zones.
const MAX_SIZE_DIFFERENCE: f64 = 1e-6;
/// Largest distance of the centres of equal zones, over the extent of the scene.
const MAX_CENTRE_DISTANCE: f64 = 1e-6;
/// Largest distance of the normals of equal zones.
const MAX_NORMAL_DISTANCE: f64 = 1e-3;
/// Least share of the zones of a reference that a solution must have.
const MIN_MATCHED: f64 = 0.5;

/// The L2 errors of a kind of zones, of the worst band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct KindErrors {
    /// Each zone alike.
    pub by_count: TotalError,
    /// By area or volume.
    pub by_size: TotalError,
}

impl KindErrors {
    fn of(bands: &[Vec<HalvedValue>]) -> KindErrors {
        let worst = |weight: ZoneWeight| {
            bands.iter().map(|v| TotalError::of(v, weight)).fold(TotalError::default(), TotalError::max)
        };
        KindErrors { by_count: worst(ZoneWeight::Count), by_size: worst(ZoneWeight::Size) }
    }

    /// The worse of both weightings.
    pub(crate) fn worst(&self) -> TotalError {
        self.by_count.max(self.by_size)
    }
}

/// A solution compared with a reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Measurement {
    /// H of patches.
    pub patches: KindErrors,
    /// G of voxel and pane zones.
    pub volumes: KindErrors,
    /// Share of the zones of the reference that the solution has.
    pub matched: f64,
    /// Median of stated over true error.
    pub ratio: Option<f64>,
    /// Share of zones within twice their stated error.
    pub within: Option<f64>,
    /// Share of powers absorbed by a surface within their stated error.
    pub names_within: Option<f64>,
    /// The smallest share of zones within twice their stated error after relighting a group by 0 or 10; `None` for one group.
    pub within_relit: Option<f64>,
    /// The same of powers absorbed by a surface.
    pub names_within_relit: Option<f64>,
}

/// A reference with the zones of a solution that are its zones: equal indices, or in a solution with another number of zones those of equal kind, centre, size
/// and normal.
struct Comparison<'a> {
    reference: &'a Reference,
    matched: Vec<Option<usize>>,
}

impl Comparison<'_> {
    fn new<'a>(reference: &'a Reference, s: &Solution) -> Result<Comparison<'a>, Error> {
        let zones: Vec<ReferenceZone> = (0..s.zones.len()).map(|i| ReferenceZone::new(&s.zones, i)).collect();
        let matched = matched_zones(&reference.zones, &zones, reference.zone_count == zones.len());
        let comparison = Comparison { reference, matched };
        if comparison.share_matched() < MIN_MATCHED {
            let (found, all) = (comparison.matched.iter().flatten().count(), reference.zones.len());
            return Err(format!("{found} of {all} zones of the reference are zones of the solution").into());
        }
        Ok(comparison)
    }

    fn share_matched(&self) -> f64 {
        self.matched.iter().flatten().count() as f64 / self.matched.len().max(1) as f64
    }

    /// The values of entry `k` of a field.
    fn compare(&self, field: &ReferenceField, k: usize, b: Band, own: HalvedValue) -> HalvedValue {
        let halves = [0, 1].map(|h: usize| field.halves[h][k][b]);
        HalvedValue { halves, noise: field.error[k][b], ..own }
    }

    /// Pairs of a kind of zones, each band with light a list.
    fn by_band(&self, field: &ReferenceField, s: &Solution, patches: bool) -> Vec<Vec<HalvedValue>> {
        let of_band = |b: Band| -> Vec<HalvedValue> {
            let zones = self.reference.zones.iter().zip(&self.matched).enumerate();
            zones
                .filter(|(_, (z, _))| (z.kind == ZoneKind::Patch) == patches)
                .filter_map(|(k, (z, i))| {
                    let (value, stated) = (s.fields.incident[(*i)?][b], s.fields.error[(*i)?][b]);
                    let own = HalvedValue { value, stated, size: z.size, ..HalvedValue::default() };
                    Some(self.compare(field, k, b, own))
                })
                .collect()
        };
        let lit = |v: &Vec<HalvedValue>| v.iter().any(|x| x.halves[0] > 0.0);
        Band::all().map(of_band).filter(lit).collect()
    }

    fn all_zones(&self, field: &ReferenceField, s: &Solution) -> Vec<HalvedValue> {
        [true, false].map(|patches| self.by_band(field, s, patches).concat()).concat()
    }

    /// Absorbed powers of the surfaces, as mean irradiances.
    fn surfaces(&self, field: &ReferenceField, s: &Solution) -> Vec<HalvedValue> {
        let first = self.reference.zones.len();
        let of_surface = |(k, name): (usize, &String)| -> Option<Vec<HalvedValue>> {
            let (own, absorbing) = (s.surface(name)?, absorbing_area(s, name)?);
            let of_band = |b: Band| {
                let (value, stated) = (own.absorbed[b] / absorbing[b], own.absorbed_error[b] / absorbing[b]);
                let own = HalvedValue { value, stated, size: own.area, ..HalvedValue::default() };
                self.compare(field, first + k, b, own)
            };
            Some(Band::all().map(of_band).collect())
        };
        self.reference.surfaces.iter().enumerate().filter_map(of_surface).flatten().collect()
    }

    /// The smallest shares of zones and of surfaces within twice their stated error after one group was relit.
    fn within_relit(&self, s: &Solution) -> Result<[Option<f64>; 2], Error> {
        let Reference { groups, fields, .. } = self.reference;
        let merged = s.groups.iter().any(|g| g.kind == LightGroupKind::All);
        let known = groups.iter().all(|g| s.groups.iter().any(|own| own.name == *g));
        let mut least = [None; 2];
        if s.groups.len() < 2 || merged || !known || s.zones.len() > MAX_RELIT_ZONES {
            return Ok(least);
        }
        for (k, group) in groups.iter().enumerate() {
            for factor in RELIGHT_FACTORS {
                let relit = relight(s.clone(), &[(group.clone(), Bands::splat(factor))])?;
                let parts = fields.iter().enumerate().map(|(j, f)| (f, if j == k { factor } else { 1.0 }));
                let field = ReferenceField::sum(parts);
                let lists = [self.all_zones(&field, &relit), self.surfaces(&field, &relit)];
                for (least, list) in least.iter_mut().zip(&lists) {
                    let share = share_within(list, 2.0);
                    *least = least.map_or(share, |l: f64| share.map(|share| share.min(l)));
                }
            }
        }
        Ok(least)
    }
}

/// Area of a surface times its absorptance, m².
fn absorbing_area(s: &Solution, name: &str) -> Option<Bands> {
    let surface = s.scene.surfaces().iter().position(|own| own.name == name)?;
    let patches = s.zones.patches.iter().enumerate().filter(|(_, p)| p.surface == surface);
    Some(patches.map(|(i, p)| (Bands::ONE - p.reflectance - s.zones.sheets.transmittance(i)) * p.area).sum())
}

/// For each zone of a reference the index of the same zone of a solution; `same` where both have the same number of zones.
fn matched_zones(reference: &[ReferenceZone], zones: &[ReferenceZone], same: bool) -> Vec<Option<usize>> {
    let extent = zones.iter().fold(0.0f64, |m, z| m.max(z.centre.max_abs()));
    let scale = MAX_CENTRE_DISTANCE * extent.max(f64::MIN_POSITIVE);
    let key = |z: &ReferenceZone| (z.centre.array().map(|x| (x / scale).round() as i64), z.kind as u8);
    let mut by_place: HashMap<([i64; 3], u8), Vec<usize>> = HashMap::new();
    if !same {
        zones.iter().enumerate().for_each(|(i, z)| by_place.entry(key(z)).or_default().push(i));
    }
    let near = |a: Vec3, b: Vec3, distance: f64| (a - b).length() <= distance;
    let equal = |z: &ReferenceZone, own: &ReferenceZone| {
        own.kind == z.kind
            && near(own.centre, z.centre, 4.0 * scale)
            && near(own.normal, z.normal, MAX_NORMAL_DISTANCE)
            && (own.size - z.size).abs() <= MAX_SIZE_DIFFERENCE * z.size
    };
    let of_zone = |z: &ReferenceZone| {
        let one = [z.index];
        let candidates = if same { one.as_slice() } else { by_place.get(&key(z)).map_or(&[][..], |l| l) };
        candidates.iter().copied().find(|&i| equal(z, &zones[i]))
    };
    reference.iter().map(of_zone).collect()
}

/// Compares a solution with a reference.
pub(crate) fn measure(s: &Solution, reference: &Reference) -> Result<Measurement, Error> {
    let (c, field) =
        (Comparison::new(reference, s)?, ReferenceField::sum(reference.fields.iter().map(|f| (f, 1.0))));
    let zones = c.all_zones(&field, s);
    let [within_relit, names_within_relit] = c.within_relit(s)?;
    Ok(Measurement {
        patches: KindErrors::of(&c.by_band(&field, s, true)),
        volumes: KindErrors::of(&c.by_band(&field, s, false)),
        matched: c.share_matched(),
        ratio: median_ratio(&zones),
        within: share_within(&zones, 2.0),
        names_within: share_within(&c.surfaces(&field, s), 1.0),
        within_relit,
        names_within_relit,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn both_sides_of_a_plate_are_told_apart() {
        let zone = |index: usize, x: f64, z: f64| ReferenceZone {
            index,
            kind: ZoneKind::Patch,
            size: 2.0,
            centre: vec3(x, 0.0, 1.0),
            normal: vec3(0.0, 0.0, z),
        };
        let (front, back, other) = (zone(0, 1.0, 1.0), zone(1, 1.0, -1.0), zone(2, 5.0, 1.0));
        // A solution with one zone more and another order.
        let own = [zone(0, 3.0, 1.0), zone(1, 1.0, -1.0), zone(2, 5.0, 1.0), zone(3, 1.0, 1.0)];
        let matched = matched_zones(&[front, back, other], &own, false);
        assert_eq!(matched, [Some(3), Some(1), Some(2)]);
        // Of as many zones, equal indices count, and only equal zones.
        assert_eq!(matched_zones(&[front, back, other], &own, true), [None, Some(1), Some(2)]);
        let larger = ReferenceZone { size: 2.1, ..other };
        assert_eq!(matched_zones(&[larger], &own, false), [None]);
    }
}
