//! Errors that a solution tells of itself: what does not add up, is less than nothing or is not finished widens the stated errors.
//!
//! With h_i what arrives at zone i (direct light included), e_i its stated error, a_i the power that the zone absorbs of one W/m² of it
//! (`energy::uptake`), and R the power that the balance misses, emitted + incoming − absorbed − escaped:
//!
//! ```text
//!     closure          e_i ≥ |d_i| h_i            d_i: what row i misses, beyond what is known of its escape, over what it holds
//!     steps            e_i += 10 r/(1−r) (h_i + mean h)   r: share of the power not distributed, where the solver ended early
//!     negative flux    e_i ≥ −h_i                  where h_i < 0 with no negative source
//!     balance          e_i += f h_i,   f = (|R| − Σ_j a_j e_j)⁺ / Σ_j a_j h_j
//! ```
//!
//! The last says: factors that lose or make power do so in proportion to what they carry, and what the stated errors do not explain of R is
//! shared out in that proportion. Where nothing absorbs, R has no such place, and the errors are unknown (infinite).
//! A sum by name errs by the sum of its zones' errors as if they had one sign; what escapes, by what the rest of the balance leaves open.

use crate::columns;
use crate::energy::{absorbed, section, uptake};
use crate::radii::of_share;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Fields, Group, SolveStatus, Zones, bands};

/// How often an undistributed power may meet a zone, for the errors of a solve that has not converged.
const MEETINGS: f64 = 10.0;

/// Share of what is given below which a balance that is off is rounding.
const ROUNDING: f64 = 1e-12;

/// Makes no error smaller than what a row misses, as `shares` of all that arrives.
pub(crate) fn closure(shares: &[Bands], fields: &mut Fields) {
    for ((e, h), d) in fields.error.iter_mut().zip(&fields.incident).zip(shares) {
        *e = bands(|b| widest(e[b], of_share(d[b].abs(), h[b])));
    }
}

/// The larger of two errors; infinite where one is not a number.
fn widest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Adds what the solver left: the power that it has not distributed, of a zone's own field and of the mean of its kind.
pub(crate) fn steps(zones: &Zones, groups: &[Group], fields: &mut Fields) {
    let done = |s: SolveStatus| matches!(s, SolveStatus::Converged | SolveStatus::Swept);
    // What is found holds 1 − r of the power, what is left r.
    let share = |r: f64| if r < 1.0 { MEETINGS * r / (1.0 - r) } else { f64::INFINITY };
    for g in groups {
        let spent = bands(|b| if done(g.status[b]) { 0.0 } else { share(g.residual[b]) });
        if spent == [0.0; 3] {
            continue;
        }
        let h = |i: usize| {
            let x = g.incident.at(i);
            bands(|b| (x[b] * g.incident_scale[b]).abs())
        };
        for kind in [0..zones.voxel_offset(), zones.voxel_offset()..zones.len()] {
            let size = kind.len().max(1) as f64;
            let mean = kind.clone().fold([0.0; 3], |m, i| bands(|b| m[b] + h(i)[b] / size));
            for i in kind {
                let own = h(i);
                fields.error[i] = bands(|b| widest(fields.error[i][b] + spent[b] * (own[b] + mean[b]), 0.0));
            }
        }
    }
}

/// Makes no error smaller than a flux below zero.
pub(crate) fn negative_flux(fields: &mut Fields) {
    for (e, h) in fields.error.iter_mut().zip(&fields.incident) {
        *e = bands(|b| widest(e[b], -h[b]));
    }
}

/// Shares out what a balance misses and neither the stated errors nor that of what escapes, `lost` (W a band), explain.
pub(crate) fn balance(zones: &Zones, energy: &Energy, lost: Bands, fields: &mut Fields) {
    let missing = bands(|b| (energy.residual[b] * (energy.emitted[b] + energy.incoming[b])).abs());
    let explained = absorbed(zones, |i| fields.error_of_all(i));
    let taken = absorbed(zones, |i| arriving(fields, i));
    let share = bands(|b| {
        let given = energy.emitted[b] + energy.incoming[b];
        let excess = missing[b] - explained[b] - lost[b];
        match () {
            // Also where it is not a number.
            () if !missing[b].is_finite() => f64::INFINITY,
            () if excess <= ROUNDING * given || explained[b].is_infinite() => 0.0,
            () if taken[b] > 0.0 => excess / taken[b],
            () => f64::INFINITY,
        }
    });
    share_out(share, fields);
}

/// All that arrives at zone `i`, direct light included, by amount, W/m².
fn arriving(fields: &Fields, i: usize) -> Bands {
    bands(|b| (fields.incident[i][b] + fields.direct[i][b]).abs())
}

/// Adds a share of all that arrives to the error of every zone; an infinite share of nothing is unknown too.
pub(crate) fn share_out(share: Bands, fields: &mut Fields) {
    if share == [0.0; 3] {
        return;
    }
    for i in 0..fields.error.len() {
        let h = arriving(fields, i);
        let more = bands(|b| of_share(share[b], h[b]));
        fields.error[i] = bands(|b| fields.error[i][b] + more[b]);
    }
}

/// The stated errors of the powers of a balance, W a band, with the `error` of what arrives at each zone (W/m²): of what zones absorb the sum of their errors, of what comes in from the surroundings the
/// root of the sum of squares, since each zone has its own rays, of what escapes all that the rest leaves open. What is emitted is given.
pub(crate) fn of_powers(
    zones: &Zones,
    energy: &Energy,
    fields: &Fields,
    error: impl Fn(usize) -> Bands + Sync,
) -> Energy {
    let mut out = Energy {
        absorbed_surfaces: energy.absorbed_surfaces.iter().map(|s| (s.0.clone(), [0.0; 3])).collect(),
        ..Energy::default()
    };
    for (i, p) in zones.patches.iter().enumerate() {
        let (a, e) = (uptake(zones, i), error(i));
        let sum = &mut out.absorbed_surfaces[p.surface].1;
        *sum = bands(|b| sum[b] + power(a[b], e[b]));
    }
    let of = |range: std::ops::Range<usize>| {
        columns::sum(range.len(), |k| {
            let (a, e) = (uptake(zones, range.start + k), error(range.start + k));
            bands(|b| power(a[b], e[b]))
        })
    };
    out.absorbed_volumes = of(zones.voxel_offset()..zones.pane_offset());
    out.absorbed_panes = of(zones.pane_offset()..zones.len());
    let squares: Bands = columns::sum(fields.surroundings_error.len(), |i| {
        let met = section(zones, i);
        bands(|b| (met[b] * fields.surroundings_error[i][b]).powi(2))
    });
    out.incoming = squares.map(f64::sqrt);
    let surfaces = out.absorbed_surfaces.iter().fold([0.0; 3], |s, x| bands(|b| s[b] + x.1[b]));
    let open = bands(|b| {
        let residual = energy.residual[b] * (energy.emitted[b] + energy.incoming[b]);
        let all = surfaces[b] + out.absorbed_volumes[b] + out.absorbed_panes[b] + out.incoming[b];
        widest(all + residual.abs(), 0.0)
    });
    // What is exactly nothing leaves by no opening.
    out.escaped = bands(|b| if energy.escaped[b] == 0.0 { 0.0 } else { open[b] });
    out.backs = bands(|b| if energy.backs[b] == 0.0 { 0.0 } else { open[b] });
    out
}

/// What a zone takes of an error; nothing of one that absorbs nothing, whatever the error.
fn power(uptake: f64, error: f64) -> f64 {
    if uptake == 0.0 { 0.0 } else { widest(uptake * error, 0.0) }
}
