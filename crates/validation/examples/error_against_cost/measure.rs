//! A solution against a reference.

use crate::reference::{Reference, ReferenceField, ReferenceZone};
use crate::scenes::Error;
use crate::solved::SolvedScene;
use crate::statistics::{ComparedValue, MeasuredError, covered, l2, median_ratio, pointwise};
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, LightGroupKind, Solution, ZoneKind};
use zonal_solve::relight::relight;

/// Factors on each light group in the check of relighting.
const RELIGHT_FACTORS: [f64; 2] = [0.0, 10.0];
/// Largest number of zones for which relit solutions are compared: each is a copy of the solution.
const MAX_RELIT_ZONES: usize = 300_000;
/// Names below this share of the mean do not count as the worst.
const MIN_SHARE_OF_MEAN: f64 = 0.1;
/// Largest relative difference of the sizes of equal zones.
const MAX_SIZE_DIFFERENCE: f64 = 1e-6;

/// A solution compared with a reference.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measurement {
    /// L2 of H over the patches, of the worst band.
    pub patches: MeasuredError,
    /// L2 of G over voxel and pane zones, of the worst band.
    pub volumes: MeasuredError,
    /// Pointwise error, of the worst band and kind.
    pub pointwise: MeasuredError,
    /// L2 over the means of H by surface name.
    pub names: MeasuredError,
    /// Largest relative error of such a mean.
    pub worst_name: f64,
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

/// The zones of a solution that are those of a reference: equal indices, or in a solution with other zones those of equal centre, kind and
/// size.
pub(crate) fn matched_zones(reference: &Reference, s: &SolvedScene) -> Result<Vec<Option<usize>>, Error> {
    let extent = s.places.iter().fold(0.0f64, |m, p| m.max(p.1.max_abs()));
    let scale = 1e-6 * extent.max(f64::MIN_POSITIVE);
    let key = |p: Vec3, kind: ZoneKind| (p.array().map(|x| (x / scale).round() as i64), kind as u8);
    let same = reference.zone_count == s.places.len();
    let by_place: HashMap<_, usize> = if same {
        HashMap::new()
    } else {
        s.places.iter().enumerate().map(|(i, p)| (key(p.1, p.0), i)).collect()
    };
    let matched = |z: &ReferenceZone| {
        let i = if same { Some(z.index) } else { by_place.get(&key(z.centre, z.kind)).copied() };
        i.filter(|&i| {
            let (kind, centre, size) = s.places[i];
            let near = (centre - z.centre).length() <= 4.0 * scale;
            kind == z.kind && near && (size - z.size).abs() <= MAX_SIZE_DIFFERENCE * z.size
        })
    };
    let all: Vec<Option<usize>> = reference.zones.iter().map(matched).collect();
    let found = all.iter().flatten().count();
    if 2 * found < all.len() {
        return Err(
            format!("{found} of {} zones of the reference are zones of the solution", all.len()).into()
        );
    }
    Ok(all)
}

/// Values of the zones of a kind in a band, beside the reference.
struct Comparison<'a> {
    reference: &'a Reference,
    matched: &'a [Option<usize>],
}

impl Comparison<'_> {
    /// Pairs of all zones that `wanted` accepts, each band a list.
    fn by_band(
        &self,
        field: &ReferenceField,
        s: &SolvedScene,
        wanted: &dyn Fn(&ReferenceZone) -> bool,
    ) -> Vec<Vec<ComparedValue>> {
        let of_band = |b: Band| {
            let zones = self.reference.zones.iter().enumerate().filter(|(_, z)| wanted(z));
            zones
                .filter_map(|(k, _)| {
                    let i = self.matched[k]?;
                    Some(field.compared(k, b, s.incident[i][b], s.error[i][b]))
                })
                .collect()
        };
        let lit = |v: &Vec<ComparedValue>| v.iter().any(|x| x.reference > 0.0);
        Band::all().map(of_band).filter(lit).collect()
    }

    /// Means over the patches of each surface, weighted by area.
    fn by_name(&self, field: &ReferenceField, s: &SolvedScene, b: Band) -> Vec<ComparedValue> {
        let mut sums: HashMap<usize, [f64; 5]> = HashMap::new();
        for (k, z) in self.reference.zones.iter().enumerate().filter(|(_, z)| z.kind == ZoneKind::Patch) {
            let Some(i) = self.matched[k] else { continue };
            let v = field.compared(k, b, s.incident[i][b], s.error[i][b]);
            let sum = sums.entry(z.surface).or_default();
            let parts = [z.size, v.value, v.reference, v.noise, v.stated].map(|x| x * z.size);
            sum[0] += z.size;
            sum[1] += parts[1];
            sum[2] += parts[2];
            sum[3] += parts[3] * parts[3];
            sum[4] += parts[4];
        }
        let mut names: Vec<(usize, [f64; 5])> = sums.into_iter().collect();
        names.sort_by_key(|n| n.0);
        let mean = |s: [f64; 5]| ComparedValue {
            value: s[1] / s[0],
            reference: s[2] / s[0],
            noise: s[3].sqrt() / s[0],
            stated: s[4] / s[0],
        };
        names.into_iter().map(|(_, s)| mean(s)).collect()
    }
}

fn worst(lists: &[Vec<ComparedValue>], of: fn(&[ComparedValue]) -> MeasuredError) -> MeasuredError {
    lists.iter().map(|v| of(v)).fold(MeasuredError::default(), MeasuredError::max)
}

/// Compares a solution with the zonal reference, and with the path-traced one.
pub(crate) fn measure(
    s: &SolvedScene,
    reference: &Reference,
    traced: Option<&Reference>,
) -> Result<Measurement, Error> {
    let matched = matched_zones(reference, s)?;
    let c = Comparison { reference, matched: &matched };
    let field = reference.total();
    let patches = c.by_band(&field, s, &|z| z.kind == ZoneKind::Patch);
    let volumes = c.by_band(&field, s, &|z| z.kind != ZoneKind::Patch);
    let contacts: Vec<ComparedValue> = c.by_band(&field, s, &|z| z.contact).concat();
    let both: Vec<ComparedValue> = [patches.concat(), volumes.concat()].concat();
    let names: Vec<Vec<ComparedValue>> = Band::all().map(|b| c.by_name(&field, s, b)).collect();
    Ok(Measurement {
        patches: worst(&patches, l2),
        volumes: worst(&volumes, l2),
        pointwise: worst(&patches, pointwise).max(worst(&volumes, pointwise)),
        names: worst(&names, l2),
        worst_name: names.iter().map(|n| worst_relative(n)).fold(0.0, f64::max),
        total: total(s, traced)?,
        ratio: median_ratio(&both),
        within: covered(&both),
        within_at_contacts: covered(&contacts),
        within_relit: match &s.solution {
            Some(solution) => within_relit(solution, reference, &matched)?,
            None => None,
        },
    })
}

fn worst_relative(names: &[ComparedValue]) -> f64 {
    let mean = names.iter().map(|v| v.reference).sum::<f64>() / names.len().max(1) as f64;
    let lit = names.iter().filter(|v| v.reference > MIN_SHARE_OF_MEAN * mean);
    lit.map(|v| ((v.value - v.reference).abs() - v.noise).max(0.0) / v.reference).fold(0.0, f64::max)
}

/// L2 against path-traced means.
fn total(s: &SolvedScene, reference: Option<&Reference>) -> Result<Option<MeasuredError>, Error> {
    let Some((reference, field)) = reference.and_then(|r| Some((r, r.traced.as_ref()?))) else {
        return Ok(None);
    };
    let matched = matched_zones(reference, s)?;
    let c = Comparison { reference, matched: &matched };
    let patches = c.by_band(field, s, &|z| z.kind == ZoneKind::Patch);
    let volumes = c.by_band(field, s, &|z| z.kind != ZoneKind::Patch);
    Ok(Some(worst(&patches, l2).max(worst(&volumes, l2))))
}

/// The smallest share of zones within twice their stated error after one group was relit.
fn within_relit(
    s: &Solution,
    reference: &Reference,
    matched: &[Option<usize>],
) -> Result<Option<f64>, Error> {
    let merged = s.groups.iter().any(|g| g.kind == LightGroupKind::All);
    let known = |g: &String| s.groups.iter().any(|own| own.name == *g);
    if s.groups.len() < 2 || merged || !reference.groups.iter().all(known) || s.zones.len() > MAX_RELIT_ZONES
    {
        return Ok(None);
    }
    let mut least = 1.0f64;
    for (k, group) in reference.groups.iter().enumerate() {
        for factor in RELIGHT_FACTORS {
            let relit = relight(s.clone(), &[(group.clone(), Bands::splat(factor))])?;
            let parts =
                reference.fields.iter().enumerate().map(|(j, f)| (f, if j == k { factor } else { 1.0 }));
            let field = ReferenceField::sum(parts, reference.zones.len());
            let c = Comparison { reference, matched };
            least = covered(&c.by_band(&field, &SolvedScene::of_fields(&relit), &|_| true).concat())
                .map_or(least, |share| share.min(least));
        }
    }
    Ok(Some(least))
}

/// The discretization error: L2 of the zonal reference against path-traced means on the same zones, of the worst band and kind.
pub(crate) fn discretization(reference: &Reference) -> Option<MeasuredError> {
    let (zonal, traced) = (reference.total(), reference.traced.as_ref()?);
    let of = |wanted: &dyn Fn(&ReferenceZone) -> bool, b: Band| -> Vec<ComparedValue> {
        let zones = reference.zones.iter().enumerate().filter(|(_, z)| wanted(z));
        zones
            .map(|(k, _)| ComparedValue {
                value: zonal.value[k][b],
                reference: traced.value[k][b],
                noise: traced.error[k][b].hypot(zonal.error[k][b]),
                stated: 0.0,
            })
            .collect()
    };
    let errors = Band::all().flat_map(|b| {
        [l2(&of(&|z| z.kind == ZoneKind::Patch, b)), l2(&of(&|z| z.kind != ZoneKind::Patch, b))]
    });
    Some(errors.fold(MeasuredError::default(), MeasuredError::max))
}
