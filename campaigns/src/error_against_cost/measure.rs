//! A solution against a reference.

use super::reference::{Reference, ReferenceField, ReferenceZone};
use crate::harness::Error;
use crate::harness::statistics::{ComparedValue, MeasuredError, covered, l2, median_ratio};
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

/// A solution compared with a reference.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measurement {
    /// L2 of H over the patches, of the worst band.
    pub patches: MeasuredError,
    /// L2 of G over voxel and pane zones, of the worst band.
    pub volumes: MeasuredError,
    /// L2 against path-traced means, of the worst band and kind; `None` without them.
    pub total: Option<MeasuredError>,
    /// Median of stated over true error.
    pub ratio: Option<f64>,
    /// Share of zones within twice their stated error.
    pub within: Option<f64>,
    /// The same at contacts.
    pub within_at_contacts: Option<f64>,
    /// The smallest such share after relighting a group by 0 or 10; `None` for one group.
    pub within_relit: Option<f64>,
}

/// A reference with the zones of a solution that are its zones: equal indices, or in a solution with other zones those of equal centre, kind
/// and size.
struct Comparison<'a> {
    reference: &'a Reference,
    matched: Vec<Option<usize>>,
}

impl Comparison<'_> {
    fn new<'a>(reference: &'a Reference, s: &Solution) -> Result<Comparison<'a>, Error> {
        let zones = || (0..s.zones.len()).map(|i| s.zones.zone(i));
        let extent = zones().fold(0.0f64, |m, z| m.max(z.centre().max_abs()));
        let scale = 1e-6 * extent.max(f64::MIN_POSITIVE);
        let key = |p: Vec3, kind: ZoneKind| (p.array().map(|x| (x / scale).round() as i64), kind as u8);
        let same = reference.zone_count == s.zones.len();
        let by_place: HashMap<_, usize> =
            zones().enumerate().filter(|_| !same).map(|(i, z)| (key(z.centre(), z.kind()), i)).collect();
        let matched = |z: &ReferenceZone| {
            let i = if same { Some(z.index) } else { by_place.get(&key(z.centre, z.kind)).copied() };
            i.filter(|&i| {
                let own = s.zones.zone(i);
                let near = (own.centre() - z.centre).length() <= 4.0 * scale;
                own.kind() == z.kind && near && (own.size() - z.size).abs() <= MAX_SIZE_DIFFERENCE * z.size
            })
        };
        let matched: Vec<Option<usize>> = reference.zones.iter().map(matched).collect();
        let (found, all) = (matched.iter().flatten().count(), matched.len());
        if 2 * found < all {
            return Err(format!("{found} of {all} zones of the reference are zones of the solution").into());
        }
        Ok(Comparison { reference, matched })
    }

    /// Pairs of all zones that `wanted` accepts, each band a list.
    fn by_band(
        &self,
        field: &ReferenceField,
        s: &Solution,
        wanted: &dyn Fn(&ReferenceZone) -> bool,
    ) -> Vec<Vec<ComparedValue>> {
        let of_band = |b: Band| {
            let zones = self.reference.zones.iter().enumerate().filter(|(_, z)| wanted(z));
            zones
                .filter_map(|(k, _)| {
                    let i = self.matched[k]?;
                    Some(field.compared(k, b, s.fields.incident[i][b], s.fields.error[i][b]))
                })
                .collect()
        };
        let lit = |v: &Vec<ComparedValue>| v.iter().any(|x| x.reference > 0.0);
        Band::all().map(of_band).filter(lit).collect()
    }

    /// Pairs of patches, and of volume zones.
    fn by_kind(&self, field: &ReferenceField, s: &Solution) -> [Vec<Vec<ComparedValue>>; 2] {
        [true, false].map(|patches| self.by_band(field, s, &|z| (z.kind == ZoneKind::Patch) == patches))
    }

    /// The smallest share of zones within twice their stated error after one group was relit.
    fn within_relit(&self, s: &Solution) -> Result<Option<f64>, Error> {
        let Reference { groups, fields, zones, .. } = self.reference;
        let merged = s.groups.iter().any(|g| g.kind == LightGroupKind::All);
        let known = groups.iter().all(|g| s.groups.iter().any(|own| own.name == *g));
        if s.groups.len() < 2 || merged || !known || s.zones.len() > MAX_RELIT_ZONES {
            return Ok(None);
        }
        let mut least = 1.0f64;
        for (k, group) in groups.iter().enumerate() {
            for factor in RELIGHT_FACTORS {
                let relit = relight(s.clone(), &[(group.clone(), Bands::splat(factor))])?;
                let parts = fields.iter().enumerate().map(|(j, f)| (f, if j == k { factor } else { 1.0 }));
                let field = ReferenceField::sum(parts, zones.len());
                let share = covered(&self.by_band(&field, &relit, &|_| true).concat());
                least = share.map_or(least, |share| share.min(least));
            }
        }
        Ok(Some(least))
    }
}

/// L2 of the worst band.
fn worst(lists: &[Vec<ComparedValue>]) -> MeasuredError {
    lists.iter().map(|v| l2(v)).fold(MeasuredError::default(), MeasuredError::max)
}

/// Compares a solution with the zonal reference, and with the path-traced one.
pub(crate) fn measure(
    s: &Solution,
    reference: &Reference,
    traced: Option<&Reference>,
) -> Result<Measurement, Error> {
    let (c, field) = (Comparison::new(reference, s)?, reference.total());
    let [patches, volumes] = c.by_kind(&field, s);
    let both: Vec<ComparedValue> = [patches.concat(), volumes.concat()].concat();
    let total = |(traced, field): (&Reference, &ReferenceField)| -> Result<MeasuredError, Error> {
        let [patches, volumes] = Comparison::new(traced, s)?.by_kind(field, s);
        Ok(worst(&patches).max(worst(&volumes)))
    };
    Ok(Measurement {
        patches: worst(&patches),
        volumes: worst(&volumes),
        total: traced.and_then(|r| Some((r, r.traced.as_ref()?))).map(total).transpose()?,
        ratio: median_ratio(&both),
        within: covered(&both),
        within_at_contacts: covered(&c.by_band(&field, s, &|z| z.contact).concat()),
        within_relit: c.within_relit(s)?,
    })
}
