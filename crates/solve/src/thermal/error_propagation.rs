//! Propagation of the errors of the incident flux through reflection and reemission.
//!
//! δh is known from the factors for the powers that the zones send out, but these powers err too. With M as in the linear equations (no entry
//! negative), δu = t c M|δh| + M δu and δh' = |δh| + g δu/t bound both. Cost: a linear solve to a residual of [`ERROR_SOLVE`]. δh contains the error of
//! direct light.

use super::coupled_bicgstab::{self, IterationCheckpoint};
use super::linearized_zone::{BandCoupling, Linearization, Place};
use super::newton::coupled_operator;
use super::nodes::NodeZones;
use super::spectral_balance::{BlockZones, SpectralBalances};
use crate::context::BlockEngine;
use crate::iteration::StoppingCriterion;
use crate::settings::SolvePurpose;
use zonal_scene::{Bands, Fields, Scene, Zones};

/// How temperatures follow from the zonal equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TemperatureSolve {
    /// From one linear solve of each band.
    Direct,
    /// By Newton's method for coupled bands.
    Newton,
}

impl TemperatureSolve {
    /// The solve of a scene whose errors want [`propagate_errors`]: none without temperatures, nor a direct one whose errors `contain_sources`, those
    /// of the powers that zones send out, nor a
    /// solve for a comparison.
    pub(crate) fn to_propagate(
        scene: &Scene,
        contain_sources: bool,
        purpose: SolvePurpose,
    ) -> Option<TemperatureSolve> {
        scene.thermal()?;
        if purpose == SolvePurpose::Comparison {
            return None;
        }
        if scene.couples_bands() {
            Some(TemperatureSolve::Newton)
        } else {
            (!contain_sources).then_some(TemperatureSolve::Direct)
        }
    }
}

/// Stopping criterion of the solve for the errors.
const ERROR_SOLVE: StoppingCriterion = StoppingCriterion { residual: 0.1, max_iterations: 200 };
/// Name of its stage.
const STAGE: &str = "state-errors";

/// Adds to the errors of the incident fields of every block of bands those of the powers that the zones send out because of them.
pub(crate) fn propagate_errors(blocks: &[BlockEngine], fields: &mut [Fields], solve: TemperatureSolve) {
    let context = &blocks[0].context;
    let zones: Vec<BlockZones> =
        blocks.iter().map(|t| BlockZones { scene: t.context.scene, zones: t.context.zones }).collect();
    let balances = SpectralBalances::new(&zones);
    let n = balances.len();
    let of_zone = |f: &Fields, i: usize| balances.first(i).incident_share * f.total_error(i);
    let share: Vec<Bands> = fields.iter().flat_map(|f| (0..n).map(|i| of_zone(f, i))).collect();
    let surfaces: Vec<usize> = context.zones.patches.iter().map(|p| p.surface).collect();
    let nodes = NodeZones::new(&balances, &surfaces);
    let linearized =
        (solve == TemperatureSolve::Newton).then(|| linearization(&balances, nodes.as_ref(), fields));
    let responses: Vec<&Zones> = zones.iter().map(|t| t.zones).collect();
    let reflected = |place: Place, h: &dyn Fn(usize) -> Bands, nodes: &[f64]| match &linearized {
        Some(all) => all.reflected(place, h, nodes),
        None => {
            let (rho, _) = responses[place.block].response(place.zone);
            rho / balances.first(place.zone).incident_share * h(place.block)
        }
    };
    // Solve for the errors of the powers sent out.
    let operator = coupled_operator(blocks, &balances, BandCoupling::of(&balances), false);
    let powers = |h: &[Bands]| {
        let absorbed = |nodes: &NodeZones| nodes.absorbed(&balances, |t, i| h[t * n + i]);
        let nodes = match (&linearized, &nodes) {
            (Some(linearized), Some(nodes)) => linearized.node_response(|| absorbed(nodes)),
            _ => Vec::new(),
        };
        operator.scaling.powers(h, |place, h| reflected(place, h, &nodes))
    };
    let source = powers(&share);
    if coupled_bicgstab::absolute_sum(&source) == 0.0 {
        return;
    }
    let checkpoint = IterationCheckpoint {
        store: context.settings.checkpoints,
        stage: STAGE,
        number: 0,
        resumes: true,
        progress: context.settings.progress,
    };
    let reflect = |u: &[Bands]| powers(&operator.incident_flux(u));
    let end = coupled_bicgstab::solve(reflect, &source, source.clone(), ERROR_SOLVE, &checkpoint);
    add_caused_errors(&balances, &operator.incident_flux(&end.u), fields);
}

/// Zones of known power and nodes, linearized about the temperatures of the radiosities found.
fn linearization(balances: &SpectralBalances, nodes: Option<&NodeZones>, fields: &[Fields]) -> Linearization {
    let incident = |t: usize, i: usize| balances.first(i).incident_flux(&fields[t], i);
    let of_nodes = nodes.map_or_else(Vec::new, |nodes| nodes.found(balances, incident));
    let emissive = |i: usize| match balances.first(i).node {
        Some(k) => of_nodes[k as usize],
        None => balances.emissive_and_net_power(i, |t| incident(t, i)).0,
    };
    let linearized = Linearization::of(balances, emissive);
    match nodes {
        Some(nodes) => linearized.with_nodes(balances, nodes, &of_nodes),
        None => linearized,
    }
}

/// Adds the errors `more` of the incident flux of all blocks, W/m², to those of their fields.
fn add_caused_errors(balances: &SpectralBalances, more: &[Bands], fields: &mut [Fields]) {
    let n = balances.len();
    for (t, fields) in fields.iter_mut().enumerate() {
        for (i, e) in fields.error.iter_mut().enumerate() {
            *e += more[t * n + i].abs() / balances.first(i).incident_share;
        }
    }
}
