//! Coefficients of one zone in the thermal equations (header of [`super`]), in one block of bands.

use zonal_math::parallel;
use zonal_scene::thermal::{blackbody_emissive_power, blackbody_temperature};
use zonal_scene::{
    BandFractions, Bands, Convection, Fields, NodeCondition, Patch, Scene, Thermal, ThermalCondition,
    ThermalNetwork, ZoneRef, Zones,
};

/// Distance from a patch, over the largest edge of a cell, at which the medium in front of it is looked up.
const OFFSET_FROM_PATCH: f64 = 1e-6;

/// Coefficients m, a, r of a zone and its thermal condition.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneBalance {
    /// m: 1, or 4κ in 1/m.
    pub weight: Bands,
    /// a: 1 − ρ, or 1 − Ω.
    pub absorb: Bands,
    /// r: ρ, or Ω.
    pub reflect: Bands,
    /// T in K, or q in W/m² or W/m³; never the power of a whole surface.
    pub condition: ThermalCondition,
    /// A in m², V in m³.
    pub measure: f64,
    /// h over H or G: 1, or ¼.
    pub incident_share: f64,
    /// The node of unknown temperature to which the zone belongs.
    pub node: Option<u32>,
    /// Convection of a zone without such a node.
    pub convection: Option<Convection>,
    /// Index of the band fractions in [`ZoneBalances::kinds`].
    kind: u32,
}

impl ZoneBalance {
    /// h (T − T∞) at the black emissive power `e`, W/m², and its derivative by e; 0 without convection.
    pub(super) fn convected(&self, e: f64) -> [f64; 2] {
        let Some(c) = self.convection else { return [0.0; 2] };
        let t = blackbody_temperature(e.max(0.0));
        [c.coefficient * (t - c.ambient), c.coefficient * temperature_slope(t)]
    }
    /// Index of the band fractions in [`Thermal::all_fractions`].
    pub(super) fn kind(&self) -> usize {
        self.kind as usize
    }
    /// m a in each band.
    pub(super) fn absorption_weight(&self) -> Bands {
        self.weight * self.absorb
    }
    /// h of zone `i`, W/m².
    pub(super) fn incident_flux(&self, fields: &Fields, i: usize) -> Bands {
        self.incident_share * (fields.incident[i] + fields.direct_light(i))
    }
}

/// Coefficients of all zones of a thermal scene by its own optical properties.
pub(super) struct ZoneBalances<'a> {
    scene: &'a Scene,
    pub thermal: &'a Thermal,
    /// The band fractions of the scene, then those of the kinds of cells.
    kinds: Vec<&'a BandFractions>,
    /// Area of each surface's patches, m².
    areas: Vec<f64>,
    /// Area of each face's patches, m²; empty where no face has a power.
    face_areas: Vec<f64>,
}

impl<'a> ZoneBalances<'a> {
    /// Of the zones of a scene in thermal mode.
    pub(super) fn new(scene: &'a Scene, zones: &Zones) -> ZoneBalances<'a> {
        let Some(thermal) = scene.thermal() else { unreachable!("only called in thermal mode") };
        let mut areas = vec![0.0; scene.surfaces().len()];
        zones.patches.iter().for_each(|p| areas[p.surface] += p.area);
        let faces = scene.faces();
        let has_power = faces.values.iter().any(|v| matches!(v.condition, Some(ThermalCondition::Power(_))));
        let mut face_areas = vec![0.0; if has_power { faces.len() } else { 0 }];
        for p in zones.patches.iter().filter(|_| has_power) {
            faces.face_of(p.facet).into_iter().for_each(|f| face_areas[f] += p.area);
        }
        ZoneBalances { scene, thermal, kinds: thermal.all_fractions().collect(), areas, face_areas }
    }
    /// Area of the patches of a facet's face, m².
    fn face_area(&self, facet: usize) -> f64 {
        self.scene.faces().face_of(facet).map_or(f64::INFINITY, |f| self.face_areas[f])
    }
    /// The band fractions of a zone.
    pub(super) fn fractions(&self, zone: &ZoneBalance) -> &'a BandFractions {
        self.kinds[zone.kind as usize]
    }
    /// The kind of band fractions in a cell; 0 outside the medium, and if all cells have those of the scene.
    fn kind_of_cell(&self, cell: Option<usize>) -> u32 {
        let own = self.thermal.cell_fractions.as_ref().zip(cell);
        own.and_then(|(f, c)| f.kind_of_cell.get(c)).map_or(0, |k| k + 1)
    }
    /// The kind of band fractions in front of a patch.
    fn kind_at_patch(&self, patch: &Patch) -> u32 {
        let (Some(grid), Some(_)) = (self.scene.voxel_grid(), &self.thermal.cell_fractions) else { return 0 };
        let offset = patch.normal * (OFFSET_FROM_PATCH * grid.cell().max_abs());
        let centre = patch.plate.centre();
        let cell = [centre + offset, centre].into_iter().find_map(|point| grid.cell_at(point));
        self.kind_of_cell(cell.map(|c| grid.index(c)))
    }
    /// ρ of patch `i`.
    fn patch_reflectance(&self, zones: &Zones, i: usize) -> Bands {
        let own = zones.own_reflectances.get(i).copied();
        own.unwrap_or_else(|| self.scene.facet_reflectance(zones.patches[i].facet))
    }
    /// Zone `i`.
    pub(super) fn of(&self, zones: &Zones, i: usize) -> ZoneBalance {
        if let Some(p) = zones.patches.get(i) {
            let known = match self.scene.faces().values_of(p.facet).condition {
                Some(ThermalCondition::Power(w)) => ThermalCondition::Flux(w / self.face_area(p.facet)),
                Some(own) => own,
                None => match self.thermal.surfaces[p.surface] {
                    ThermalCondition::Power(w) => ThermalCondition::Flux(w / self.areas[p.surface]),
                    known => known,
                },
            };
            let reflect = self.patch_reflectance(zones, i);
            let node = self.network().and_then(|n| n.surface_nodes[p.surface].filter(|k| n.is_unknown(*k)));
            let is_free = node.is_none() && !matches!(known, ThermalCondition::Temperature(_));
            return ZoneBalance {
                weight: Bands::ONE,
                absorb: 1.0 - reflect,
                reflect,
                condition: known,
                measure: p.area,
                incident_share: 1.0,
                node: node.map(|k| k as u32),
                convection: self.network().filter(|_| is_free).and_then(|n| n.convection[p.surface]),
                kind: self.kind_at_patch(p),
            };
        }
        let (kappa, albedo, known, kind) = match (zones.zone(i), self.scene.voxel_grid()) {
            (ZoneRef::Voxel(_, v), Some(grid)) => {
                let known = grid.heat(v.cell).unwrap_or(ThermalCondition::Flux(0.0));
                (grid.extinction(v.cell), grid.albedo(v.cell), known, self.kind_of_cell(Some(v.cell)))
            }
            (ZoneRef::Pane(_, p), _) => {
                let pane = &self.scene.panes()[p.pane];
                (pane.extinction, pane.albedo, self.thermal.panes[p.pane], 0)
            }
            _ => unreachable!("a scene with voxel zones has a voxel grid"),
        };
        ZoneBalance {
            weight: 4.0 * kappa,
            absorb: 1.0 - albedo,
            reflect: albedo,
            condition: known,
            measure: zones.response(i).1,
            incident_share: 0.25,
            node: None,
            convection: None,
            kind,
        }
    }
    /// Nodes and convection of the scene.
    pub(super) fn network(&self) -> Option<&'a ThermalNetwork> {
        self.thermal.network.as_ref()
    }
    /// Initial temperature, K: the mean of the known temperatures of surfaces and surroundings, or that of the medium.
    pub(super) fn initial_temperature(&self) -> f64 {
        let surfaces = self.thermal.surfaces.iter().chain(&self.thermal.panes);
        let mut list: Vec<f64> = surfaces.filter_map(|k| temperature_of(*k)).collect();
        list.extend(self.thermal.surroundings);
        if list.is_empty() {
            list.extend(self.scene.voxel_grid().and_then(|m| m.heat(0)).and_then(temperature_of));
        }
        if let Some(network) = self.network().filter(|_| list.is_empty()) {
            list.extend(network.nodes.iter().filter_map(|n| match n.condition {
                NodeCondition::Temperature(t) => Some(t),
                NodeCondition::Power(_) => None,
            }));
            list.extend(network.convection.iter().flatten().map(|c| c.ambient));
        }
        let mean = list.iter().map(|t| blackbody_emissive_power(*t)).sum::<f64>() / list.len().max(1) as f64;
        if list.is_empty() { 300.0 } else { blackbody_temperature(mean) }
    }
    /// All zones.
    pub(super) fn all(&self, zones: &Zones) -> Vec<ZoneBalance> {
        parallel::collect(zones.len(), |i| self.of(zones, i))
    }
}

/// dT/de of a black emissive power e = σT⁴, K m²/W.
pub(super) fn temperature_slope(t: f64) -> f64 {
    t / (4.0 * blackbody_emissive_power(t)).max(f64::MIN_POSITIVE)
}

fn temperature_of(known: ThermalCondition) -> Option<f64> {
    if let ThermalCondition::Temperature(t) = known { Some(t) } else { None }
}
