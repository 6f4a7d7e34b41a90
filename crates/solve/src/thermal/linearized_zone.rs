//! Linearization of the radiosity of a zone about an emissive power, and the scaling of the unknowns of the linear solve.

use super::nodes::{NodeLinearization, NodeZones};
use super::spectral_balance::SpectralBalances;
use super::zone_balance::ZoneBalance;
use crate::operator::{ExchangeOperator, extend_to_slopes};
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{BandFractions, Bands, ThermalCondition, Zones};

/// Whether the bands of a linear solve differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BandCoupling {
    /// All bands have the same coefficients and sources.
    Identical,
    /// Bands differ.
    Distinct,
}

impl BandCoupling {
    /// Of a grey scene, or of one with band fractions.
    pub(super) fn of(balances: &SpectralBalances) -> BandCoupling {
        if balances.is_grey() { BandCoupling::Identical } else { BandCoupling::Distinct }
    }
}

/// Radiosity of a zone in one block of bands as a linear function of the incident flux.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearizedZone {
    pub own: Bands,
    pub reflect: Bands,
    /// a ψ/S, and m a; both 0 if the temperature is known. In a node a ψ, and 0.
    pub reemitted: Bands,
    pub absorption: Bands,
    /// The node of unknown temperature to which the zone belongs.
    pub node: Option<u32>,
}

/// The radiosities of all zones in every block of bands as linear functions of the incident flux.
pub(super) struct Linearization {
    /// The zones of each block.
    pub blocks: Vec<Vec<LinearizedZone>>,
    /// The balances of the nodes.
    nodes: Option<NodeLinearization>,
}

impl Linearization {
    /// About the black emissive powers of all zones, W/m².
    pub(super) fn of(balances: &SpectralBalances, emissive: impl Fn(usize) -> f64 + Sync) -> Linearization {
        let blocks = balances.blocks();
        let all: Vec<Vec<LinearizedZone>> =
            parallel::collect(balances.len(), |i| linearize(balances, i, emissive(i)));
        let blocks = (0..blocks).map(|t| parallel::map(&all, |z| z[t])).collect();
        Linearization { blocks, nodes: None }
    }
    /// With the balances of the nodes about their black emissive powers `e`, W/m².
    pub(super) fn with_nodes(
        mut self,
        balances: &SpectralBalances,
        nodes: &NodeZones,
        e: &[f64],
    ) -> Linearization {
        let linear = nodes.linearize(balances, e);
        for zone in self.blocks.iter_mut().flatten() {
            if let Some(k) = zone.node {
                zone.own += zone.reemitted * linear.own(k as usize);
            }
        }
        self.nodes = Some(linear);
        self
    }
    /// Change of the black emissive power of every node by the power that all of them absorb, W/m²; empty without nodes.
    pub(super) fn node_response(&self, absorbed: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
        self.nodes.as_ref().map_or_else(Vec::new, |n| n.response(&absorbed()))
    }
    /// The part of the radiosity of a zone that depends on the incident flux `h` of every block, and on the response of its node.
    pub(super) fn reflected(&self, place: Place, h: &dyn Fn(usize) -> Bands, nodes: &[f64]) -> Bands {
        let zone = &self.blocks[place.block][place.zone];
        if let Some(k) = zone.node {
            // A body at one temperature has no slope.
            let change = if place.is_slope { 0.0 } else { nodes[k as usize] };
            return zone.reflect * h(place.block) + zone.reemitted * change;
        }
        zone.reflect * h(place.block) + zone.reemitted * self.absorbed(place.zone, h)
    }
    /// Power that zone `i` absorbs and reemits for an incident flux `h` of every block, W/m² or W/m³.
    pub(super) fn absorbed(&self, i: usize, h: impl Fn(usize) -> Bands) -> f64 {
        let of = |t: usize| (self.blocks[t][i].absorption * h(t)).sum();
        (1..self.blocks.len()).fold(of(0), |s, t| s + of(t))
    }
}

/// A zone as if its black emissive power `e` were known, and w with its slope.
fn fixed_zone(l: &ZoneBalance, fractions: &BandFractions, e: f64) -> (LinearizedZone, [Bands; 2]) {
    let [w, slope] = fractions.emissive_powers(e);
    let fixed = LinearizedZone {
        own: l.absorb * w,
        reflect: l.reflect,
        reemitted: Bands::ZERO,
        absorption: Bands::ZERO,
        node: None,
    };
    (fixed, [w, slope])
}

/// Zone `i` about the black emissive power `e` in every block.
fn linearize(balances: &SpectralBalances, i: usize, e: f64) -> Vec<LinearizedZone> {
    let blocks = 0..balances.blocks();
    let mut parts: Vec<(LinearizedZone, [Bands; 2])> =
        blocks.clone().map(|t| fixed_zone(&balances.zones[t][i], balances.fractions(t, i), e)).collect();
    let q = match balances.first(i).condition {
        ThermalCondition::Temperature(_) => return parts.into_iter().map(|p| p.0).collect(),
        ThermalCondition::Flux(q) | ThermalCondition::Power(q) => q,
    };
    if parts.iter().any(|(_, [_, slope])| slope.any(|s| s < 0.0)) {
        let t = blackbody_temperature(e.max(0.0));
        parts.iter_mut().zip(blocks).for_each(|(p, k)| p.1[1] = balances.fractions(k, i).grey_gas_weights(t));
    }
    if let Some(node) = balances.first(i).node {
        let of_node = |(t, (fixed, [_, slope])): (usize, &(LinearizedZone, [Bands; 2]))| LinearizedZone {
            reemitted: balances.zones[t][i].absorb * *slope,
            node: Some(node),
            ..*fixed
        };
        return parts.iter().enumerate().map(of_node).collect();
    }
    let counted = balances.counted();
    let absorption = |t: usize| balances.zones[t][i].absorption_weight() * counted;
    let sum = |value: &dyn Fn(usize) -> Bands| {
        (1..parts.len()).fold((absorption(0) * value(0)).sum(), |s, t| s + (absorption(t) * value(t)).sum())
    };
    let [convected, more] = balances.first(i).convected(e);
    let all = sum(&|t| parts[t].1[1]) + more;
    if all <= 0.0 {
        return parts.into_iter().map(|p| p.0).collect();
    }
    let missing = (q - convected - sum(&|t| parts[t].1[0])) / all;
    let coupled = |(t, (fixed, [w, slope])): (usize, &(LinearizedZone, [Bands; 2]))| {
        let l = &balances.zones[t][i];
        LinearizedZone {
            own: l.absorb * (*w + *slope * missing),
            reemitted: l.absorb * *slope / all,
            absorption: absorption(t),
            ..*fixed
        }
    };
    parts.iter().enumerate().map(coupled).collect()
}

/// Conversion between radiosities and powers of all unknowns, for the linear solve.
pub(super) struct PowerScaling {
    /// t and c.
    scale: Vec<(f64, Bands)>,
    /// h over P: 1/A or 1/(4V).
    pub flux_over_power: Vec<f64>,
    /// The zone of every higher-order unknown.
    slope_zones: Vec<u32>,
    zones: usize,
    /// True if all bands are identical and one product serves all.
    one_band: bool,
}

impl PowerScaling {
    /// For zones with their balances and higher-order unknowns; `bands` says whether all bands are identical.
    pub(super) fn new(
        operator: &dyn ExchangeOperator,
        zones: &Zones,
        locals: &[ZoneBalance],
        bands: BandCoupling,
        slope_zones: &[u32],
    ) -> PowerScaling {
        let mut scale: Vec<(f64, Bands)> = parallel::collect(zones.len(), |i| {
            (closure_target(zones, i), scaled_radiosity_coefficient(zones, i))
        });
        let mut flux_over_power: Vec<f64> = locals.iter().map(|l| l.incident_share / l.measure).collect();
        extend_to_slopes(&mut scale, slope_zones);
        extend_to_slopes(&mut flux_over_power, slope_zones);
        let (slope_zones, zones) = (slope_zones.to_vec(), zones.len());
        // Without the higher-order unknowns only products of all bands are available.
        let one_band = bands == BandCoupling::Identical
            && operator.has_identical_bands()
            && operator.len() == scale.len();
        PowerScaling { scale, flux_over_power, slope_zones, zones, one_band }
    }
    /// The zone of an unknown.
    pub(super) fn zone(&self, k: usize) -> usize {
        if k < self.zones { k } else { self.slope_zones[k - self.zones] as usize }
    }
    /// Power of an unknown with a radiosity, W.
    pub(super) fn power_of(&self, i: usize, radiosity: Bands) -> Bands {
        let (t, c) = self.scale[i];
        t * c * radiosity
    }
    pub(super) fn strengths(&self, u: &[Bands]) -> Vec<Bands> {
        parallel::collect(u.len(), |i| u[i] / self.scale[i].0)
    }
    /// h of every unknown by the exchange between the zones.
    pub(super) fn incident_flux(&self, operator: &dyn ExchangeOperator, u: &[Bands]) -> Vec<Bands> {
        let s = self.strengths(u);
        let mut p: Vec<Bands> = if self.one_band {
            let first: Vec<[f64; 1]> = parallel::map(&s, |s| [s.first()]);
            parallel::map(&operator.apply_band(&first), |p| Bands::splat(p[0]))
        } else if s.len() < operator.len() {
            operator.apply(&s)
        } else {
            let mut columns = vec![s];
            operator.replace_many(&mut columns);
            columns.pop().unwrap_or_default()
        };
        parallel::for_each_pair(&mut p, &self.flux_over_power, |p, o| *p *= *o);
        p
    }
}

/// The operators of all blocks of bands, with one vector of powers: the unknowns of one block after those of the other.
pub(super) struct CoupledOperator<'a> {
    /// The operator of each block. The zones are common to all; each has higher-order unknowns or none.
    pub operators: Vec<&'a dyn ExchangeOperator>,
    /// True if processes share the products: all make them in one order.
    pub is_shared: bool,
    /// Their scaling.
    pub scaling: CoupledScaling,
}

impl CoupledOperator<'_> {
    /// h of every unknown by the exchange between the zones, W/m².
    pub(super) fn incident_flux(&self, u: &[Bands]) -> Vec<Bands> {
        let of_block =
            |t: usize| self.scaling.blocks[t].incident_flux(self.operators[t], &u[self.scaling.range(t)]);
        let blocks = self.operators.len();
        let mut parts: Vec<Vec<Bands>> = if self.is_shared {
            (0..blocks).map(of_block).collect()
        } else {
            parallel::collect_tasks(blocks, of_block)
        };
        if blocks == 1 {
            return parts.pop().unwrap_or_default();
        }
        let mut out = Vec::with_capacity(self.scaling.len());
        parts.iter().for_each(|part| out.extend_from_slice(part));
        out
    }
}

/// Conversion between radiosities and powers of the unknowns of all blocks of bands. A block without higher-order unknowns has constant fields
/// in its zones: its slopes are 0 where another block has some.
pub(super) struct CoupledScaling {
    /// That of each block.
    pub blocks: Vec<PowerScaling>,
    /// Index of the first unknown of each block, and the number of all.
    offsets: Vec<usize>,
}

impl CoupledScaling {
    /// Of the blocks of a scene.
    pub(super) fn new(blocks: Vec<PowerScaling>) -> CoupledScaling {
        let mut offsets = vec![0];
        blocks.iter().for_each(|s| offsets.push(offsets[offsets.len() - 1] + s.flux_over_power.len()));
        CoupledScaling { blocks, offsets }
    }
    /// Number of unknowns of all blocks.
    pub(super) fn len(&self) -> usize {
        self.offsets[self.blocks.len()]
    }
    /// The unknowns of a block among those of all.
    pub(super) fn range(&self, block: usize) -> std::ops::Range<usize> {
        self.offsets[block]..self.offsets[block + 1]
    }
    /// The block and the unknown in it of an unknown of all blocks.
    pub(super) fn place(&self, k: usize) -> (usize, usize) {
        let block = self.offsets.partition_point(|first| *first <= k) - 1;
        (block, k - self.offsets[block])
    }
    /// The entry of an unknown of block `t` in a vector over all unknowns; 0 if the block does not have it.
    fn entry(&self, h: &[Bands], t: usize, unknown: usize) -> Bands {
        let k = self.offsets[t] + unknown;
        if k < self.offsets[t + 1] { h[k] } else { Bands::ZERO }
    }
    /// Powers of all unknowns, W. `radiosity` gives that of a block's unknown and its zone from the incident fluxes of all blocks.
    pub(super) fn powers(
        &self,
        h: &[Bands],
        radiosity: impl Fn(Place, &dyn Fn(usize) -> Bands) -> Bands + Sync,
    ) -> Vec<Bands> {
        let one = |k: usize| {
            let (block, unknown) = self.place(k);
            let scaling = &self.blocks[block];
            let place = Place { block, zone: scaling.zone(unknown), is_slope: unknown >= scaling.zones };
            scaling.power_of(unknown, radiosity(place, &|t: usize| self.entry(h, t, unknown)))
        };
        parallel::collect(self.len(), one)
    }
}

/// An unknown of a block of bands.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub block: usize,
    /// Its zone.
    pub zone: usize,
    /// True if it is a higher-order unknown.
    pub is_slope: bool,
}
