//! Errors of zones whose samples met no light.
//!
//! Samples that are all zero have no variance; they do not show how much they missed. Of the light U_i that zone i would receive if nothing hid it, N
//! samples without a hit leave a visible share p with the likelihood (1 − p)^N, so that p ≤ 3/N with a probability of 95 % (the rule of three; Hanley
//! and Lippman-Hand 1983). Where all g zones of a group of neighbours met nothing, each stands for the others in part:
//!
//! ```text
//!     e_i = 3 U_i/(N_i √g)          N_i the samples and the stored rays of zone i
//!     e_i = H_i of the stored rays, where these met light
//! ```
//!
//! U_i is the larger of two estimates, by patches as connections are aimed at and by any zones, with the sky where it is sampled. It is zero where no zone that sends light
//! is in front: a convex body in the open has no such error.

use super::gather_sums::GatherSums;
use super::gather_task::GatherTask;
use super::zone_gather::{GatherScratch, Gatherer};
use crate::settings::zone_power::fluence_factor;
use rayon::prelude::*;
use zonal_scene::Bands;

/// Share that N samples without a hit leave, times N.
const RULE_OF_THREE: f64 = 3.0;
/// Share of U below which light is not looked for any further.
const LEVEL_SHARE: f64 = 0.01;

/// What is known of the zones whose samples met no light.
#[derive(Default)]
pub(super) struct UnmetLight {
    /// H or G of the groups by the stored rays, W/m²; empty until samples of some zones met no light.
    stored: Vec<Vec<Bands>>,
    /// Largest radiosity of every group, W/m².
    lit: Vec<Bands>,
    /// U of the groups, W/m², of the zones whose samples met no light; otherwise empty.
    unhidden: Vec<Vec<Bands>>,
}

impl UnmetLight {
    /// Raises the `errors` of the zones of a kind in groups that met no light, in the quantities and bands concerned. `values` and `errors` are those of the
    /// columns, then of their sum.
    pub(super) fn contain(
        &mut self,
        gatherer: &Gatherer,
        task: &GatherTask,
        sums: &GatherSums,
        kind: usize,
        values: &[Vec<Bands>],
        errors: &mut [Vec<Bands>],
    ) {
        if self.lit.is_empty() {
            self.lit = gatherer.brightest(task.groups);
        }
        let blocks: Vec<(&[u32], Vec<Bands>)> = task
            .zone_groups
            .of_kind(kind)
            .into_par_iter()
            .map(|block| (block, missing(block, values, &self.lit)))
            .filter(|(_, missing)| missing.iter().any(|m| *m != Bands::ZERO))
            .collect();
        if blocks.is_empty() {
            return;
        }
        self.complete(gatherer, task, &blocks);
        for (block, missing) in &blocks {
            let together = (block.len() as f64).sqrt();
            for i in block.iter().map(|i| *i as usize) {
                let samples = 2.0 * sums.counts[i] as f64 + task.stored_rays[kind.min(1)] as f64;
                let scale = fluence_factor(task.zones, i) * RULE_OF_THREE / (samples * together);
                for (q, (errors, missing)) in errors.iter_mut().zip(missing).enumerate() {
                    let met = self.met_by_rays(q, i);
                    let all = of_quantity(&self.unhidden[i], q);
                    let e = met.zip_map(scale * all, |met, e| if met > 0.0 { met } else { e });
                    errors[i] = errors[i].max(e * *missing);
                }
            }
        }
    }

    /// The level of quantity `q` of zone `i` to which errors are relative where no samples met light: the field by the stored rays, or else a small share of U.
    pub(super) fn level(&self, q: usize, i: usize) -> Bands {
        let all = self.unhidden.get(i).map_or(Bands::ZERO, |u| of_quantity(u, q));
        self.met_by_rays(q, i).max(LEVEL_SHARE * all)
    }

    /// Quantity `q` of zone `i` by the stored rays, where samples of some zones met no light; otherwise zero.
    fn met_by_rays(&self, q: usize, i: usize) -> Bands {
        match self.stored.get(q) {
            Some(column) => column[i],
            None => self.stored.iter().map(|c| c[i]).sum(),
        }
    }

    /// Determines what is not yet known of the zones of these blocks.
    fn complete(&mut self, gatherer: &Gatherer, task: &GatherTask, blocks: &[(&[u32], Vec<Bands>)]) {
        if self.stored.is_empty() {
            self.stored = (task.stored)();
            self.unhidden = vec![Vec::new(); task.zones.len()];
        }
        let unknown = |i: &usize| self.unhidden[*i].is_empty();
        let zones: Vec<usize> =
            blocks.iter().flat_map(|(block, _)| block.iter().map(|i| *i as usize)).filter(unknown).collect();
        let of_zone =
            |scratch: &mut GatherScratch, i: &usize| gatherer.unhidden_light(*i, task.groups, scratch);
        let found: Vec<Vec<Bands>> = zones.par_iter().map_init(GatherScratch::default, of_zone).collect();
        zones.into_iter().zip(found).for_each(|(i, u)| self.unhidden[i] = u);
    }
}

/// Column `q` of a list, or the sum of all beyond the last.
fn of_quantity(columns: &[Bands], q: usize) -> Bands {
    columns.get(q).copied().unwrap_or_else(|| columns.iter().sum())
}

/// 1 in the quantities and bands that are `lit` and of which no zone of a block met anything, else 0.
fn missing(block: &[u32], values: &[Vec<Bands>], lit: &[Bands]) -> Vec<Bands> {
    let in_quantity = |(q, v): (usize, &Vec<Bands>)| {
        let most = block.iter().fold(Bands::ZERO, |m, i| m.max(v[*i as usize].abs()));
        most.zip_map(of_quantity(lit, q), |most, lit| if most == 0.0 && lit > 0.0 { 1.0 } else { 0.0 })
    };
    values.iter().enumerate().map(in_quantity).collect()
}
