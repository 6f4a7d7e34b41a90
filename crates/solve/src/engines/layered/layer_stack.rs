//! Applicability of the layered engine: a box on the grid of its medium, periodic along two axes, whose zones are equal in each layer.

use crate::engines::dense::band_groups::BandGroups;
use crate::engines::spectral::enclosure::{BoxEnclosure, OPENING};
use zonal_scene::{Bands, Scene, Zones};

/// Relative deviation from the third axis, from a plane and from the area of the period that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Layers between two ends. Elements are the lower end, the layers of cells, the upper end, and panes. A pane that crosses a layer of cells divides it into
/// sheets, which are one element.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerStack {
    /// Extinctions of the sheets, 1/m.
    pub(crate) extinction: Vec<Bands>,
    /// Their thicknesses, m.
    pub(crate) thickness: Vec<f64>,
    /// The element of the lower end, of each sheet, and of the upper end.
    pub(crate) element_of_sheet: Vec<u32>,
    /// Number of layers of cells.
    pub(crate) layers: usize,
    /// Number of panes.
    pub(crate) panes: usize,
    /// Area of the period, m².
    pub(crate) area: f64,
    /// The element of each zone, and its share of the area of the period.
    pub(crate) element: Vec<u32>,
    pub(crate) share: Vec<f64>,
    /// True at ends without a wall.
    pub(crate) open: [bool; 2],
}

/// True for a scene that is periodic along two axes and whose extinction varies, or that has panes.
pub(crate) fn needs_layers(scene: &Scene) -> bool {
    scene.periodic().iter().filter(|p| **p).count() == 2
        && scene.voxel_grid().is_some_and(|m| m.uniform_extinction().is_none() || !scene.panes().is_empty())
}

/// A pane that fills the period.
struct CrossingPane {
    pane: usize,
    /// Its coordinate on the third axis, m.
    position: f64,
    /// Its zones, as indices into those of the panes.
    zones: Vec<usize>,
}

impl LayerStack {
    /// The layers of a scene, or the reason why it has none.
    pub fn find(scene: &Scene, zones: &Zones) -> Result<LayerStack, String> {
        let periodic = scene.periodic();
        let map = scene.voxel_grid().ok_or("there is no medium")?;
        let mut across = (0..3).filter(|&k| !periodic[k]);
        let (Some(axis), None) = (across.next(), across.next()) else {
            return Err("the scene is not periodic along two axes".into());
        };
        let BoxEnclosure { grid, faces, .. } =
            BoxEnclosure::without_outside(scene, zones, map.extinction(0))?;
        let layers = grid.cells[axis];
        let area = (0..3).filter(|&k| k != axis).map(|k| grid.edges[k] * grid.cells[k] as f64).product();
        let panes = pane_layers(scene, zones, axis, area)?;
        let mut stack = LayerStack {
            extinction: Vec::with_capacity(layers),
            thickness: Vec::with_capacity(layers),
            element_of_sheet: Vec::with_capacity(layers + 2),
            layers,
            panes: panes.len(),
            area,
            element: vec![0; zones.len()],
            share: Vec::new(),
            open: [false; 2],
        };
        for (side, ends) in faces[axis].iter().enumerate() {
            stack.open[side] = ends.iter().all(|z| *z == OPENING);
            if !stack.open[side] {
                let element = if side == 0 { 0 } else { layers + 1 };
                stack.add_wall(scene, zones, ends, element as u32)?;
            }
        }
        let mut first: Vec<Option<usize>> = vec![None; layers];
        for (i, v) in zones.voxels.iter().enumerate() {
            let layer = map.coordinates(v.cell)[axis];
            stack.element[zones.voxel_index(i)] = layer as u32 + 1;
            let f = zones.voxels.at(*first[layer].get_or_insert(i));
            let same = (v.extinction, v.albedo, v.emission, v.source)
                == (f.extinction, f.albedo, f.emission, f.source)
                && map.heat(v.cell) == map.heat(f.cell);
            if !same {
                return Err(format!("the medium varies within layer {layer}, along a periodic axis"));
            }
        }
        let of_layer = |f: &Option<usize>| f.map_or(Bands::ZERO, |i| zones.voxels.at(i).extinction);
        let extinction: Vec<Bands> = first.iter().map(of_layer).collect();
        stack.add_sheets(&extinction, map.min()[axis], grid.edges[axis], zones, &panes);
        stack.set_shares(zones);
        Ok(stack)
    }

    /// Adds the sheets from the lower end to the upper one: layers of cells of thickness `edge` from `start` on, divided by the panes, and the panes.
    fn add_sheets(
        &mut self,
        extinction: &[Bands],
        start: f64,
        edge: f64,
        zones: &Zones,
        panes: &[CrossingPane],
    ) {
        self.element_of_sheet.push(0);
        let mut next = 0;
        for (layer, kappa) in extinction.iter().enumerate() {
            let (mut from, to) = (0.0, edge);
            let low = start + layer as f64 * edge;
            while next < panes.len() {
                let at = panes[next].position - low;
                let is_last = layer + 1 == extinction.len();
                if at > to - ROUNDING * edge && !is_last {
                    break;
                }
                if at > from + ROUNDING * edge && at < to - ROUNDING * edge {
                    self.add_sheet(*kappa, at - from, layer as u32 + 1);
                    from = at;
                } else if at >= to - ROUNDING * edge {
                    self.add_sheet(*kappa, to - from, layer as u32 + 1);
                    from = to;
                }
                let element = (self.layers + 2 + next) as u32;
                for &k in &panes[next].zones {
                    self.element[zones.pane_index(k)] = element;
                }
                let own = &zones.panes[panes[next].zones[0]];
                self.add_sheet(own.extinction, own.thickness, element);
                next += 1;
            }
            if from < to {
                self.add_sheet(*kappa, to - from, layer as u32 + 1);
            }
        }
        self.element_of_sheet.push(self.layers as u32 + 1);
    }

    /// Adds a sheet of positive thickness.
    fn add_sheet(&mut self, extinction: Bands, thickness: f64, element: u32) {
        if thickness > 0.0 {
            self.extinction.push(extinction);
            self.thickness.push(thickness);
            self.element_of_sheet.push(element);
        }
    }

    /// Sets the shares of the zones in the area of their element.
    fn set_shares(&mut self, zones: &Zones) {
        let mut sum = vec![0.0; self.elements()];
        let size = |i: usize| zones.response(i).1;
        self.element.iter().enumerate().for_each(|(i, e)| sum[*e as usize] += size(i));
        let counts = self.zone_counts();
        let share = |zone: usize| {
            let element = self.element[zone] as usize;
            if element >= self.layers + 2 {
                return size(zone) / sum[element];
            }
            // Cells and their faces have one size.
            1.0 / f64::from(counts[element])
        };
        self.share = (0..self.element.len()).map(share).collect();
    }

    /// Assigns the patches of a wall to its element; all must be equal.
    fn add_wall(&mut self, scene: &Scene, zones: &Zones, ends: &[u32], element: u32) -> Result<(), String> {
        let patch = |z: u32| zones.patches.get(z as usize);
        let first = ends.first().and_then(|z| patch(*z));
        for &z in ends {
            let (Some(p), Some(f)) = (patch(z), first) else {
                return Err("a wall fills the period in part: close it, or omit it".into());
            };
            if (p.surface, p.reflectance, p.emission) != (f.surface, f.reflectance, f.emission) {
                let name = &scene.surfaces()[p.surface].name;
                return Err(format!("the wall of surface '{name}' varies along a periodic axis"));
            }
            self.element[z as usize] = element;
        }
        Ok(())
    }

    /// Number of elements.
    pub(crate) fn elements(&self) -> usize {
        self.layers + 2 + self.panes
    }

    /// True if an end has no wall.
    pub(crate) fn is_open(&self) -> bool {
        self.open != [false; 2]
    }

    /// Number of zones of each element.
    fn zone_counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.elements()];
        self.element.iter().for_each(|e| counts[*e as usize] += 1);
        counts
    }

    /// Smallest optical thickness above 0 of a layer; 1 if there is none below.
    pub(crate) fn smallest_depth(&self) -> f64 {
        let sheets = self.extinction.iter().zip(&self.thickness);
        let depths = sheets.flat_map(|(k, d)| k.into_iter().map(move |k| k * d));
        depths.filter(|a| *a > 0.0).fold(1.0, f64::min)
    }

    /// The groups of bands with equal extinctions.
    pub(crate) fn band_groups(&self) -> BandGroups {
        BandGroups::of(|a, b| self.extinction.iter().all(|k| k[a] == k[b]))
    }
}

/// The panes of a scene along an axis, by ascending position, or the reason why one does not fill the period of area `area`, m².
fn pane_layers(scene: &Scene, zones: &Zones, axis: usize, area: f64) -> Result<Vec<CrossingPane>, String> {
    let Some((min, max)) = scene.boundary_box() else { return Err("there is no medium".into()) };
    let slack = ROUNDING * (max[axis] - min[axis]);
    let mut out: Vec<CrossingPane> = Vec::new();
    for (k, zone) in zones.panes.iter().enumerate() {
        let (name, position) = (&scene.panes()[zone.pane].name, zone.plate.centre()[axis]);
        if zone.normal[axis].abs() < 1.0 - ROUNDING {
            return Err(format!(
                "pane '{name}' does not lie across the axis that ends: turn it, or give it as cells"
            ));
        }
        if position < min[axis] - slack || position > max[axis] + slack {
            return Err(format!(
                "pane '{name}' lies outside the medium: extend the medium, whose extinction may be 0"
            ));
        }
        let same = |p: &&mut CrossingPane| p.pane == zone.pane && (p.position - position).abs() <= slack;
        match out.iter_mut().find(same) {
            Some(found) => found.zones.push(k),
            None => out.push(CrossingPane { pane: zone.pane, position, zones: vec![k] }),
        }
    }
    for p in &out {
        let own: f64 = p.zones.iter().map(|&k| zones.panes[k].area).sum();
        if (own - area).abs() > ROUNDING * area {
            let name = &scene.panes()[p.pane].name;
            return Err(format!(
                "pane '{name}' covers {own} of {area} m² of the period at {} m: extend it over the whole period, or end the scene by walls",
                p.position
            ));
        }
    }
    out.sort_by(|a, b| a.position.total_cmp(&b.position).then(a.pane.cmp(&b.pane)));
    Ok(out)
}
