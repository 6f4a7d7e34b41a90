//! Exchange among merged patches ([`MergedPatches`]).
//!
//! With the mean M over the groups, weighted by the areas, and exchange areas g, the operator is Mᵀ g M: strengths are averaged, and the incident power of a
//! group is shared out by area. Mᵀ g M is symmetric, and its rows sum to those of g.

use crate::operator::{ErrorModel, ExchangeOperator, IncidentPower};
use zonal_math::Grade;
use zonal_scene::{Bands, Zones};

/// The groups of merged patches, each patch with its share of the area of its group.
pub(crate) struct PatchGroups {
    groups: Vec<Vec<(u32, f64)>>,
}

impl PatchGroups {
    /// The groups of zones; `None` if no patches are merged.
    pub(crate) fn of(zones: &Zones) -> Option<PatchGroups> {
        if zones.merged.is_empty() {
            return None;
        }
        let shares = |group: &Vec<u32>| {
            let area = |i: u32| zones.patches[i as usize].area;
            let total: f64 = group.iter().map(|&i| area(i)).sum();
            group.iter().map(|&i| (i, area(i) / total)).collect()
        };
        Some(PatchGroups { groups: zones.merged.groups().iter().map(shares).collect() })
    }

    /// Replaces the strengths of patches, W/m², by the mean of their group.
    pub(crate) fn average(&self, strengths: &mut [Bands]) {
        for group in &self.groups {
            let mean = group.iter().fold(Bands::ZERO, |s, &(i, share)| s + share * strengths[i as usize]);
            group.iter().for_each(|&(i, _)| strengths[i as usize] = mean);
        }
    }

    /// Shares out the incident power of each group, W, by area.
    pub(crate) fn share_out(&self, power: &mut [Bands]) {
        for group in &self.groups {
            let total = group.iter().fold(Bands::ZERO, |s, &(i, _)| s + power[i as usize]);
            group.iter().for_each(|&(i, share)| power[i as usize] = share * total);
        }
    }

    /// The strengths with those of each group replaced by their mean.
    pub(crate) fn averaged(&self, strengths: &[Bands]) -> Vec<Bands> {
        let mut out = strengths.to_vec();
        self.average(&mut out);
        out
    }
}

/// An operator with merged patches.
pub(crate) struct MergedOperator<'a> {
    /// The operator of the single patches.
    pub operator: Box<dyn ErrorModel + 'a>,
    /// The groups.
    pub groups: PatchGroups,
}

impl ExchangeOperator for MergedOperator<'_> {
    fn len(&self) -> usize {
        self.operator.len()
    }
    fn slope_zones(&self) -> Vec<u32> {
        self.operator.slope_zones()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let mut power = self.operator.apply(&self.groups.averaged(strengths));
        self.groups.share_out(&mut power);
        power
    }
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        let averaged: Vec<Vec<Bands>> = columns.iter().map(|s| self.groups.averaged(s)).collect();
        let mut out = self.operator.apply_many(&averaged);
        out.iter_mut().for_each(|power| self.groups.share_out(power));
        out
    }
    fn scale(&mut self, d: &[Bands]) {
        self.operator.scale(d);
    }
}

impl ErrorModel for MergedOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        self.operator.error(&self.groups.averaged(strengths))
    }
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        let averaged: Vec<Vec<Bands>> = columns.iter().map(|s| self.groups.averaged(s)).collect();
        let mut out = self.operator.incident_power(&averaged);
        out.columns.iter_mut().for_each(|power| self.groups.share_out(power));
        out
    }
    fn grade(&self) -> Grade {
        self.operator.grade()
    }
}
