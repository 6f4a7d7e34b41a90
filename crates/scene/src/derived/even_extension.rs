//! Even extensions: a scene with symmetry planes as the part of a larger scene without them.
//!
//! A symmetry plane is an end of the boundary box. A field u of the scene continues beyond the symmetry plane x = c as the even function
//!
//! ```text
//!     u(2c − x) = u(x)
//! ```
//!
//! so that a perfect specular reflection at c is straight transport in the extension. Each mirrored axis doubles the scene: 2, 4 or 8 images, one
//! for each subset of the mirrored axes. Symmetry planes at both ends of an axis make the extension periodic, with a period of twice the extent.
//!
//! With zones g·j, the images of zone j, and F' the exchange areas of the extension, those of the scene are
//!
//! ```text
//!     F_ij = Σ_g F'(i, g·j) = Σ_g F'(g·i, j) = F_ji
//! ```
//!
//! Zones of the extension: patches image by image, so that they ascend with the facets; voxel zones by cell; pane zones pane by pane. A pane
//! holds its own plates, then those of its images. A net power in W belongs to the scene; the extension has one for each image.

use crate::bands::Bands;
use crate::base::scene_error::SceneError;
use crate::geometry::plate::{Plate, PlateKind};
use crate::medium::grid_geometry::GridGeometry;
use crate::medium::voxel_grid::VoxelGrid;
use crate::model::light::Light;
use crate::model::shading::{CornerNormals, ShadingNormals};
use crate::model::surface::Facet;
use crate::scene::Scene;
use crate::scene::scene_parts::SceneParts;
use crate::solution::Solution;
use crate::solution::fields::{Fields, ThermalFields};
use crate::solution::light_group::{LightGroup, ZoneValues};
use crate::thermal::{Thermal, ThermalCondition};
use crate::zones::sheet_sides::SheetSides;
use crate::zones::voxel_zones::{VoxelPlace, VoxelZones};
use crate::zones::{PaneZone, Patch, Zones};
use zonal_math::Vec3;

/// A reflection at planes across some axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reflection {
    /// The coordinate of the plane across each axis that is reflected, m.
    planes: [Option<f64>; 3],
}

impl Reflection {
    fn axes(&self) -> [bool; 3] {
        self.planes.map(|p| p.is_some())
    }

    fn point(&self, p: Vec3) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| self.planes[k].map_or(p[k], |c| 2.0 * c - p[k])))
    }

    fn vector(&self, v: Vec3) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| if self.planes[k].is_some() { -v[k] } else { v[k] }))
    }

    /// True if the reflection exchanges left and right: then edges swap, and fronts stay fronts.
    fn swaps_edges(&self) -> bool {
        self.axes().iter().filter(|a| **a).count() % 2 == 1
    }

    fn plate(&self, p: &Plate) -> Plate {
        let out = Plate {
            origin: self.point(p.origin),
            e1: self.vector(p.e1),
            e2: self.vector(p.e2),
            kind: p.kind,
        };
        if self.swaps_edges() { out.flipped() } else { out }
    }

    fn facet(&self, f: &Facet) -> Facet {
        let uv = if self.swaps_edges() { [f.uv[0], f.uv[2], f.uv[1]] } else { f.uv };
        Facet { surface: f.surface, plate: self.plate(&f.plate), uv }
    }

    /// The corner normals of the image of a facet of `kind`.
    fn corner_normals(&self, normals: &CornerNormals, kind: PlateKind) -> CornerNormals {
        let image =
            normals.map(|n| self.vector(Vec3::from_array(n.map(f64::from))).array().map(|x| x as f32));
        let [a, b, c, d] = image;
        match (self.swaps_edges(), kind) {
            (false, _) => image,
            (true, PlateKind::Parallelogram) => [a, d, c, b],
            (true, PlateKind::Triangle) => [a, c, b, b],
        }
    }

    fn patch(&self, p: &Patch, facet: usize) -> Patch {
        Patch { facet, plate: self.plate(&p.plate), normal: self.vector(p.normal), ..p.clone() }
    }

    fn pane_zone(&self, p: &PaneZone) -> PaneZone {
        PaneZone { plate: self.plate(&p.plate), normal: self.vector(p.normal), ..p.clone() }
    }
}

/// The zones of an even extension and their images: zone `base[k]` of the scene for zone k of the extension.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneImages {
    base: Vec<u32>,
    /// The images of each zone of the scene, image by image: `of[i * count + g]`.
    of: Vec<u32>,
    count: usize,
}

impl ZoneImages {
    fn new(base: Vec<u32>, count: usize) -> ZoneImages {
        let mut of = vec![0; base.len()];
        let mut found = vec![0; base.len() / count];
        for (k, &i) in (0u32..).zip(&base) {
            of[i as usize * count + found[i as usize]] = k;
            found[i as usize] += 1;
        }
        ZoneImages { base, of, count }
    }

    /// Number of zones of the scene.
    #[must_use]
    pub fn zone_count(&self) -> usize {
        self.base.len() / self.count
    }

    /// Number of images of each zone, itself included.
    #[must_use]
    pub fn image_count(&self) -> usize {
        self.count
    }

    /// The images of zone `i` of the scene, as zones of the extension; `i` is below [`ZoneImages::zone_count`].
    #[must_use]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.of[i * self.count..(i + 1) * self.count]
    }

    /// The value of every zone of the extension from those of the scene; an empty list stays empty.
    #[must_use]
    pub fn extended<T: Copy>(&self, values: &[T]) -> Vec<T> {
        if values.is_empty() { Vec::new() } else { self.base.iter().map(|&i| values[i as usize]).collect() }
    }

    /// The mean over the images of every zone; an empty list stays empty.
    #[must_use]
    pub fn mean(&self, values: &[Bands]) -> Vec<Bands> {
        let sum = |i: usize| self.of(i).iter().fold(Bands::ZERO, |s, &k| s + values[k as usize]);
        let range = 0..if values.is_empty() { 0 } else { self.zone_count() };
        range.map(|i| sum(i) / self.count as f64).collect()
    }

    /// The root mean square over the images of every zone; an empty list stays empty.
    #[must_use]
    pub fn root_mean_square(&self, values: &[Bands]) -> Vec<Bands> {
        let squares: Vec<Bands> = values.iter().map(|v| v.map(|x| x * x)).collect();
        self.mean(&squares).into_iter().map(Bands::sqrt).collect()
    }

    fn mean_values(&self, values: &ZoneValues) -> ZoneValues {
        let all: Vec<Bands> = (0..values.len()).map(|k| values.at(k)).collect();
        let mean = self.mean(&all);
        match values {
            ZoneValues::Double(_) => ZoneValues::Double(mean),
            ZoneValues::Single(_) => ZoneValues::Single(mean.iter().map(|x| x.map(|x| x as f32)).collect()),
        }
    }

    fn extended_values(&self, values: &ZoneValues) -> ZoneValues {
        match values {
            ZoneValues::Double(v) => ZoneValues::Double(self.extended(v)),
            ZoneValues::Single(v) => ZoneValues::Single(self.extended(v)),
        }
    }

    /// A light group of the scene from that of the extension: means over the images, and the powers of one image.
    #[must_use]
    pub fn mean_group(&self, group: LightGroup) -> LightGroup {
        let mut out = LightGroup {
            incident: self.mean_values(&group.incident),
            error: self.mean_values(&group.error),
            direct: self.mean_values(&group.direct),
            direct_error: self.mean_values(&group.direct_error),
            ..group
        };
        out.energy.scale(Bands::splat(1.0 / self.count as f64));
        out
    }

    /// A light group of the extension from that of the scene.
    #[must_use]
    pub fn extended_group(&self, group: &LightGroup) -> LightGroup {
        let mut out = LightGroup {
            incident: self.extended_values(&group.incident),
            error: self.extended_values(&group.error),
            direct: self.extended_values(&group.direct),
            direct_error: self.extended_values(&group.direct_error),
            ..group.clone()
        };
        out.energy.scale(Bands::splat(self.count as f64));
        out
    }
}

/// The even extension of a scene with symmetry planes.
#[derive(Clone, Debug)]
pub struct EvenExtension {
    /// The extension, without symmetry planes. Its suns and point lights are those of the scene, without images ([`EvenExtension::light_images`]).
    pub scene: Scene,
    /// The images; the first one is the scene itself.
    reflections: Vec<Reflection>,
    /// Number of facets of the scene.
    facets: usize,
    /// Cells of the scene along each axis, and how many of the extension lie before them.
    cells: Option<([usize; 3], [usize; 3])>,
    bounds: (Vec3, Vec3),
}

/// Multiplies the powers of whole surfaces and bodies.
fn scale_powers(thermal: &mut Thermal, factor: f64) {
    for condition in thermal.surfaces.iter_mut().chain(&mut thermal.panes) {
        if let ThermalCondition::Power(power) = condition {
            *power *= factor;
        }
    }
    thermal.network.iter_mut().for_each(|n| n.scale(factor));
}

/// The shading normals of a scene and its images.
fn extend_shading(scene: &Scene, reflections: &[Reflection]) -> ShadingNormals {
    let mut out = ShadingNormals::default();
    out.maps.clone_from(&scene.shading().maps);
    for (g, r) in reflections.iter().enumerate() {
        for (facet, normals) in scene.shading().facets() {
            let kind = scene.facets()[facet].plate.kind;
            out.push_checked((facet + g * scene.facets().len()) as u32, r.corner_normals(normals, kind));
        }
    }
    out
}

impl EvenExtension {
    /// The even extension of a scene; `None` without symmetry planes.
    ///
    /// # Errors
    /// If the medium of the extension has too many cells.
    pub fn of(scene: &Scene) -> Result<Option<EvenExtension>, SceneError> {
        let Some(bounds) = scene.boundary_box().filter(|_| scene.has_symmetry_planes()) else {
            return Ok(None);
        };
        let symmetry_planes = scene.symmetry_planes();
        let plane = |k: usize| match symmetry_planes[k] {
            [_, true] => Some(bounds.1[k]),
            [true, false] => Some(bounds.0[k]),
            _ => None,
        };
        let planes = [0, 1, 2].map(plane);
        let mut reflections = vec![Reflection { planes: [None; 3] }];
        for (k, plane) in planes.iter().enumerate().filter(|(_, p)| p.is_some()) {
            let more = reflections.clone().into_iter().map(|mut r| {
                r.planes[k] = *plane;
                r
            });
            reflections.extend(more);
        }
        let images = reflections.len();
        let patch_size = scene.patch_size();
        let mut parts = scene.clone().into_parts();
        parts.facets = reflections.iter().flat_map(|r| scene.facets().iter().map(|f| r.facet(f))).collect();
        parts.shading = extend_shading(scene, &reflections);
        for pane in &mut parts.panes {
            pane.plates = reflections.iter().flat_map(|r| pane.plates.iter().map(|p| r.plate(p))).collect();
        }
        let mut cells = None;
        if let Some(grid) = scene.voxel_grid() {
            let low = [0, 1, 2].map(|k| symmetry_planes[k] == [true, false]);
            let before = [0, 1, 2].map(|k| if low[k] { grid.dims()[k] } else { 0 });
            cells = Some((grid.dims(), before));
            let extended = extend_medium(&mut parts, grid, planes.map(|p| p.is_some()), low)?;
            parts.voxel_grid = Some(extended);
        }
        parts.thermal.iter_mut().for_each(|t| scale_powers(t, images as f64));
        (0..3).for_each(|k| parts.periodic[k] |= symmetry_planes[k] == [true; 2]);
        parts.symmetry_planes = Default::default();
        if let Some((min, max)) = &mut parts.boundary_box {
            let corners: Vec<Vec3> =
                reflections.iter().flat_map(|r| [r.point(*min), r.point(*max)]).collect();
            (*min, *max) = corners.iter().fold((*min, *max), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        }
        parts.options.patch_size = Some(patch_size);
        let facets = scene.facets().len();
        Ok(Some(EvenExtension { scene: Scene::of_checked_parts(parts), reflections, facets, cells, bounds }))
    }

    /// Number of images of the scene, itself included: 2, 4 or 8.
    #[must_use]
    pub fn image_count(&self) -> usize {
        self.reflections.len()
    }

    /// The zones of the scene among zones that were built from the extension.
    #[must_use]
    pub fn zones_of_part(&self, all: &Zones) -> Zones {
        let patches: Vec<Patch> = all.patches.iter().filter(|p| p.facet < self.facets).cloned().collect();
        let inside = |p: &PaneZone| {
            let centre = p.plate.centre();
            let moved = |r: &Reflection| {
                let q = r.point(centre);
                (0..3).all(|k| r.planes[k].is_none() || (self.bounds.0[k]..=self.bounds.1[k]).contains(&q[k]))
            };
            // A centre of an image lies outside; reflected, it lies inside.
            !self.reflections[1..].iter().any(moved)
        };
        let panes = all.panes.iter().filter(|p| inside(p)).cloned().collect();
        let sheets = SheetSides::of(&self.scene, &patches);
        let mut out = Zones { patches, panes, sheets, ..Zones::default() };
        let (Some(grid), Some((dims, before))) = (self.scene.voxel_grid(), self.cells) else { return out };
        let geometry = GridGeometry { min: grid.corner(before), cell: grid.cell(), dims };
        let (mut places, mut of_zone) = (Vec::new(), Vec::new());
        for cell in 0..geometry.len() {
            let at = self.cell_in_extension(coordinates(cell, dims), before);
            for i in all.voxel_zones_of_cell(at) {
                let zone = all.voxels.at(i);
                let (centre, volume, samples) = (zone.centre, zone.volume, zone.samples.clone());
                places.push(VoxelPlace { cell, centre, volume, samples });
                of_zone.push(i);
            }
        }
        out.voxels = VoxelZones::with_properties_of(geometry, places, &all.voxels, &of_zone);
        out
    }

    fn cell_in_extension(&self, c: [usize; 3], before: [usize; 3]) -> usize {
        let moved = [0, 1, 2].map(|k| c[k] + before[k]);
        self.scene.voxel_grid().map_or(0, |g| g.index(moved))
    }

    /// The zones of the extension from those of the scene, and the images of each zone.
    #[must_use]
    pub fn extended_zones(&self, zones: &Zones) -> (Zones, ZoneImages) {
        let mut out = Zones::default();
        let mut base: Vec<u32> = Vec::with_capacity(zones.len() * self.image_count());
        for (g, r) in self.reflections.iter().enumerate() {
            out.patches.extend(zones.patches.iter().map(|p| r.patch(p, p.facet + g * self.facets)));
            out.own_reflectances.extend(&zones.own_reflectances);
            base.extend(0..zones.patches.len() as u32);
        }
        out.sheets = SheetSides::of(&self.scene, &out.patches);
        out.merged = zones.merged.repeated(self.image_count(), zones.patches.len());
        self.extend_voxels(zones, &mut out, &mut base);
        let mut first = 0;
        for same_pane in zones.panes.chunk_by(|a, b| a.pane == b.pane) {
            for r in &self.reflections {
                out.panes.extend(same_pane.iter().map(|p| r.pane_zone(p)));
                base.extend((0..same_pane.len()).map(|k| zones.pane_index(first + k) as u32));
            }
            first += same_pane.len();
        }
        (out, ZoneImages::new(base, self.image_count()))
    }

    /// Adds the voxel zones of the extension by ascending cell.
    fn extend_voxels(&self, zones: &Zones, out: &mut Zones, base: &mut Vec<u32>) {
        let (Some(grid), Some((dims, before))) = (self.scene.voxel_grid(), self.cells) else { return };
        let (mut places, mut of_zone) = (Vec::new(), Vec::new());
        for cell in 0..grid.len() {
            let c = grid.coordinates(cell);
            // The cell of the scene, and the axes across which it is reflected.
            let reflected = [0, 1, 2].map(|k| c[k] < before[k] || c[k] >= before[k] + dims[k]);
            let at = [0, 1, 2].map(|k| {
                if !reflected[k] {
                    c[k] - before[k]
                } else if before[k] > 0 {
                    before[k] - 1 - c[k]
                } else {
                    2 * dims[k] - 1 - c[k]
                }
            });
            let r = self.reflections.iter().find(|r| r.axes() == reflected).unwrap_or(&self.reflections[0]);
            let from = zones.voxel_zones_of_cell((at[0] * dims[1] + at[1]) * dims[2] + at[2]);
            for z in from {
                let zone = zones.voxels.at(z);
                let samples = zone.samples.reflected(reflected, grid.corner(c), grid.cell(), zone.volume);
                let (centre, volume) = (r.point(zone.centre), zone.volume);
                places.push(VoxelPlace { cell, centre, volume, samples });
                of_zone.push(z);
            }
        }
        base.extend(of_zone.iter().map(|z| zones.voxel_index(*z) as u32));
        out.voxels = VoxelZones::with_properties_of(*grid.geometry(), places, &zones.voxels, &of_zone);
    }

    /// Number of distinct images of a light: of a sun, those with distinct directions; of a point light all; of a sky and of emitting surfaces 1,
    /// whose images are part of the extension.
    #[must_use]
    pub fn light_images(&self, light: &Light) -> usize {
        1 + self.further_images(light).len()
    }

    /// The extension with all images of its suns and point lights, and the light of the scene that each of its lights is an image of, by index.
    #[must_use]
    pub fn lit_scene(&self) -> (Scene, Vec<usize>) {
        let mut parts = self.scene.clone().into_parts();
        let mut light_of: Vec<usize> = (0..parts.lights.len()).collect();
        for (l, light) in self.scene.lights().iter().enumerate() {
            let images = self.further_images(light);
            light_of.extend(images.iter().map(|_| l));
            parts.lights.extend(images);
        }
        (Scene::of_checked_parts(parts), light_of)
    }

    /// The distinct images of a light but itself.
    fn further_images(&self, light: &Light) -> Vec<Light> {
        let mut out = Vec::new();
        for r in &self.reflections {
            let image = light.image(|p| r.point(p), |v| r.vector(v));
            if image != *light && !out.contains(&image) {
                out.push(image);
            }
        }
        out
    }

    /// A solution of the scene on the whole extension, with all images of its suns and point lights, for pictures.
    #[must_use]
    pub fn extended_solution(&self, solution: &Solution) -> Solution {
        let (zones, images) = self.extended_zones(&solution.zones);
        let heat = |heat: &ThermalFields| ThermalFields {
            temperature: images.extended(&heat.temperature),
            temperature_error: images.extended(&heat.temperature_error),
            net: images.extended(&heat.net),
            net_error: images.extended(&heat.net_error),
        };
        let radiation = solution.fields.map_lists(|list| images.extended(list));
        let fields = Fields { heat: solution.fields.heat.as_ref().map(heat), ..radiation };
        Solution {
            scene: self.lit_scene().0,
            zones,
            fields,
            groups: solution.groups.iter().map(|g| images.extended_group(g)).collect(),
            report: solution.report.clone(),
            further_blocks: Vec::new(),
            scene_hash: solution.scene_hash.clone(),
            version: solution.version.clone(),
        }
    }
}

/// The even extension of a grid; band fractions of its cells follow.
fn extend_medium(
    parts: &mut SceneParts,
    grid: &VoxelGrid,
    axes: [bool; 3],
    low: [bool; 3],
) -> Result<VoxelGrid, SceneError> {
    let extended = grid.evenly_extended(axes, low)?;
    if let Some(own) = parts.thermal.as_mut().and_then(|t| t.cell_fractions.as_mut()) {
        let images = grid.cells_of_extension(axes, low, &extended);
        own.kind_of_cell = images.into_iter().map(|c| own.kind_of_cell[c]).collect();
    }
    Ok(extended)
}

fn coordinates(cell: usize, dims: [usize; 3]) -> [usize; 3] {
    [cell / (dims[1] * dims[2]), cell / dims[2] % dims[1], cell % dims[2]]
}
