//! Temperatures and net powers by name: sums over the zones of each surface, of the medium and of each pane.

use super::nodes::NodeZones;
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{HeatRow, HeatRowKind, NodeResult, Scene, Zones};

/// Sums over the zones of one name.
#[derive(Clone, Copy, Default)]
pub(super) struct ZoneSums {
    /// Area or volume, m² or m³.
    pub size: f64,
    /// Size of the zones with a temperature, and Σ E and Σ δE over it.
    pub emissive: [f64; 3],
    /// Net power and its error, W.
    pub power: [f64; 2],
    /// Absorbed sunlight, W.
    pub sunlight: f64,
}

impl ZoneSums {
    fn plus(self, x: ZoneSums) -> ZoneSums {
        ZoneSums {
            size: self.size + x.size,
            emissive: [0, 1, 2].map(|k| self.emissive[k] + x.emissive[k]),
            power: [0, 1].map(|k| self.power[k] + x.power[k]),
            sunlight: self.sunlight + x.sunlight,
        }
    }
}

/// The results of the nodes for their E and δE, W/m²; `radiated` gives the net power that a zone radiates, W.
pub(super) fn nodes(
    nodes: Option<&NodeZones>,
    e: &[f64],
    errors: &[f64],
    radiated: impl Fn(usize) -> f64,
) -> Vec<NodeResult> {
    let Some(nodes) = nodes else { return Vec::new() };
    let of_node = |k: usize| {
        let (temperature, [convected, conducted]) = (blackbody_temperature(e[k]), nodes.heat_flows(k, e));
        NodeResult {
            name: nodes.name(k).to_string(),
            temperature,
            temperature_error: if nodes.is_unknown(k) { 0.25 * temperature * errors[k] / e[k] } else { 0.0 },
            radiated: nodes.zones(k).iter().map(|i| radiated(*i as usize)).sum(),
            convected,
            conducted,
        }
    };
    (0..nodes.len()).map(of_node).collect()
}

/// The rows of the table. `undistributed` is the power that the solver left undistributed, W; `of_zone` gives the sums of one zone for its size.
pub(super) fn rows(
    scene: &Scene,
    zones: &Zones,
    undistributed: f64,
    of_zone: impl Fn(usize, f64) -> ZoneSums,
) -> Vec<HeatRow> {
    let row = |name: &str, kind: HeatRowKind, list: &mut dyn Iterator<Item = (usize, f64)>| {
        let s = list.map(|(i, size)| of_zone(i, size)).fold(ZoneSums::default(), ZoneSums::plus);
        let [size, e, de] = s.emissive;
        let mean = (size > 0.0).then(|| blackbody_temperature(e / size));
        HeatRow {
            name: name.to_string(),
            kind,
            size: s.size,
            temperature: mean,
            temperature_error: mean.map(|t| if e > 0.0 { 0.25 * t * de / e } else { 0.0 }),
            power: s.power[0],
            // A known power does not depend on the solver.
            power_error: s.power[1] + if s.power[1] > 0.0 { undistributed } else { 0.0 },
            absorbed_sunlight: scene.bands().has_solar_band().then_some(s.sunlight),
        }
    };
    let mut by_surface: Vec<Vec<(usize, f64)>> = vec![Vec::new(); scene.surfaces().len()];
    zones.patches.iter().enumerate().for_each(|(i, p)| by_surface[p.surface].push((i, p.area)));
    let mut rows: Vec<HeatRow> = scene
        .surfaces()
        .iter()
        .zip(by_surface)
        .map(|(s, list)| row(&s.name, HeatRowKind::Surface, &mut list.into_iter()))
        .collect();
    if !zones.voxels.is_empty() {
        let mut list = zones.voxels.iter().enumerate().map(|(k, v)| (zones.voxel_index(k), v.volume));
        rows.push(row("medium", HeatRowKind::Medium, &mut list));
    }
    for (k, pane) in scene.panes().iter().enumerate() {
        let own = zones.panes.iter().enumerate().filter(|(_, p)| p.pane == k);
        let mut list = own.map(|(j, p)| (zones.pane_index(j), p.area * p.thickness));
        rows.push(row(&pane.name, HeatRowKind::Pane, &mut list));
    }
    rows
}
