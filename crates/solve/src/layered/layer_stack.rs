//! Applicability of the layered engine: a box on the grid of its medium, periodic along two axes, whose zones are equal in each layer.

use crate::spectral::enclosure::{BoxEnclosure, OPENING};
use zonal_scene::{Band, Bands, PerBand, Scene, Zones};

/// Layers between two ends. Elements are the lower end, the layers, and the upper end.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerStack {
    /// Extinctions of the layers, 1/m.
    pub(crate) extinction: Vec<Bands>,
    /// Thickness of a layer, m.
    pub(crate) thickness: f64,
    /// Area of the period, m².
    pub(crate) area: f64,
    /// The element of each zone.
    pub(crate) element: Vec<u32>,
    /// True at ends without a wall.
    pub(crate) open: [bool; 2],
}

/// True for a scene that is periodic along two axes and whose extinction varies.
pub(crate) fn has_varying_layers(scene: &Scene) -> bool {
    scene.periodic().iter().filter(|p| **p).count() == 2
        && scene.voxel_grid().is_some_and(|m| m.uniform_extinction().is_none())
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
        let BoxEnclosure { grid, faces, .. } = BoxEnclosure::locate(scene, zones, map.extinction(0))?;
        let layers = grid.cells[axis];
        let mut stack = LayerStack {
            extinction: Vec::with_capacity(layers),
            thickness: grid.edges[axis],
            area: (0..3).filter(|&k| k != axis).map(|k| grid.edges[k] * grid.cells[k] as f64).product(),
            element: vec![0; zones.len()],
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
            stack.element[zones.voxel_offset() + i] = layer as u32 + 1;
            let f = zones.voxels.at(*first[layer].get_or_insert(i));
            let same = (v.extinction, v.albedo, v.emission, v.source)
                == (f.extinction, f.albedo, f.emission, f.source)
                && map.heat(v.cell) == map.heat(f.cell);
            if !same {
                return Err(format!("the medium varies within layer {layer}, along a periodic axis"));
            }
        }
        let of_layer = |f: &Option<usize>| f.map_or(Bands::ZERO, |i| zones.voxels.at(i).extinction);
        stack.extinction = first.iter().map(of_layer).collect();
        Ok(stack)
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
        self.extinction.len() + 2
    }

    /// True if an end has no wall.
    pub(crate) fn is_open(&self) -> bool {
        self.open != [false; 2]
    }

    /// Number of zones of each element.
    pub(crate) fn zone_counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.elements()];
        self.element.iter().for_each(|e| counts[*e as usize] += 1);
        counts
    }

    /// Smallest optical thickness above 0 of a layer; 1 if there is none below.
    pub(crate) fn smallest_depth(&self) -> f64 {
        let depths = self.extinction.iter().flatten().map(|k| k * self.thickness);
        depths.filter(|a| *a > 0.0).fold(1.0, f64::min)
    }

    /// The group of each band with equal extinctions, and the first band of each group.
    pub(crate) fn band_groups(&self) -> (PerBand<usize>, Vec<Band>) {
        let mut firsts: Vec<Band> = Vec::new();
        let mut group = PerBand::splat(0);
        for b in Band::all() {
            let same = |a: &Band| self.extinction.iter().all(|k| k[*a] == k[b]);
            group[b] = firsts.iter().position(same).unwrap_or_else(|| {
                firsts.push(b);
                firsts.len() - 1
            });
        }
        (group, firsts)
    }
}
