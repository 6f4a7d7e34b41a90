//! The scene: validated at construction and read-only afterwards.

pub(crate) mod blocks;
pub(crate) mod scene_parts;
pub(crate) mod symmetry_validation;
pub(crate) mod thermal_validation;
pub(crate) mod validation;

use crate::bands::Bands;
use crate::bands::band_set::BandSet;
use crate::base::diagnostic::Diagnostic;
use crate::base::printable::printable;
use crate::base::scene_error::SceneError;
use crate::medium::voxel_grid::VoxelGrid;
use crate::model::camera::Camera;
use crate::model::face_table::FaceTable;
use crate::model::light::{Light, Surroundings};
use crate::model::options::SolveOptions;
use crate::model::shading::{ShadedPoint, ShadingNormals, SidedFacet, curved_point, mapped_normal};
use crate::model::surface::{Facet, Pane, Surface, Texture};
use crate::scene::scene_parts::{BlockOptics, SceneGeometry, SceneParts, endless_axes, extent_or};
use crate::scene::validation::check_parts;
use crate::thermal::emissivity::SideEmissivity;
use crate::thermal::{Thermal, ThermalCondition};
use crate::zones::Patch;
use std::borrow::Cow;
use std::sync::Arc;
use zonal_math::Vec3;

/// Patch edges of a scene's diagonal, if no patch size is given.
const DEFAULT_PATCHES_PER_DIAGONAL: f64 = 30.0;

/// A validated scene.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, Surface};
/// let wall = Surface {
///     name: "wall".into(),
///     emission: Bands::ONE,
///     ..Surface::default()
/// };
/// let plate = Plate::parallelogram(Vec3::ZERO, vec3(3.0, 0.0, 0.0), vec3(0.0, 4.0, 0.0));
/// let parts = SceneParts {
///     surfaces: vec![wall],
///     facets: vec![Facet { surface: 0, plate, uv: [[0.0; 2]; 3] }],
///     ..SceneParts::default()
/// };
/// let scene = Scene::new(parts)?;
/// assert_eq!(scene.diagonal(), 5.0);
/// assert_eq!(scene.emission_at(0, 0.5, 0.5), Bands::ONE);
///
/// let error = Scene::new(SceneParts::default()).unwrap_err();
/// assert_eq!(error.key(), "scene");
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    geometry: Arc<SceneGeometry>,
    /// The optical properties of each block of bands, of which there is at least one. The accessors show the first.
    optics: Vec<Arc<BlockOptics>>,
}

impl Scene {
    /// Validates the parts. Control characters in names are escaped. A scene in thermal mode without fractions of the emission is grey and has one band.
    ///
    /// # Errors
    /// If the scene is empty, a value is out of range, an index is invalid or a name is not unique.
    pub fn new(mut parts: SceneParts) -> Result<Scene, SceneError> {
        parts.names_mut().for_each(escape_name);
        parts.give_grey_band();
        check_parts(&parts)?;
        Ok(Scene::of_checked_parts(parts))
    }

    /// The bands of the whole scene.
    pub fn bands(&self) -> &BandSet {
        &self.geometry.bands
    }
    /// A scene of parts that are valid by construction.
    pub(crate) fn of_checked_parts(parts: SceneParts) -> Scene {
        let (geometry, optics) = parts.divided();
        Scene { geometry: Arc::new(geometry), optics: vec![Arc::new(optics)] }
    }

    /// The optical properties of the first block.
    #[inline]
    fn own(&self) -> &BlockOptics {
        &self.optics[0]
    }

    /// Thermal conditions; `None` in light mode.
    pub fn thermal(&self) -> Option<&Thermal> {
        self.own().thermal.as_ref()
    }
    /// Name.
    pub fn name(&self) -> &str {
        &self.geometry.name
    }
    /// Surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.own().surfaces
    }
    /// Facets of all surfaces.
    pub fn facets(&self) -> &[Facet] {
        &self.geometry.facets
    }
    /// Normals for pictures of facets that stand for curved surfaces.
    pub fn shading(&self) -> &ShadingNormals {
        &self.geometry.shading
    }
    /// The point of the curved surface for which a facet stands at its parameters (u, v), seen from its front or back and at least `lift` metres above that side, and the
    /// unit normal there, without normal maps; `None` of a flat facet.
    pub fn curved_point(&self, side: SidedFacet, uv: [f64; 2], lift: f64) -> Option<ShadedPoint> {
        let corners = self.geometry.shading.of_facet(side.facet)?;
        let at = curved_point(&self.geometry.facets[side.facet], &corners, side.front, uv);
        Some(self.point_above(side, at, lift))
    }
    /// As [`Scene::curved_point`], with the normal map of the surface, if it has one; `None` of a facet that is shaded as it is.
    pub fn shaded_point(&self, side: SidedFacet, uv: [f64; 2], lift: f64) -> Option<ShadedPoint> {
        let f = &self.geometry.facets[side.facet];
        let Some(map) = self.geometry.shading.map_of(f.surface) else {
            return self.curved_point(side, uv, lift);
        };
        let corners = self.geometry.shading.of_facet(side.facet).unwrap_or([f.plate.normal(); 4]);
        let at = curved_point(f, &corners, side.front, uv);
        let texture = &self.own().textures[map.texture];
        let normal = mapped_normal(f, at.normal, f.uv_at(uv[0], uv[1]), texture, map.scale);
        Some(self.point_above(side, ShadedPoint { normal, ..at }, lift))
    }
    /// A point of the front of a facet as its front or back, raised by `lift` metres.
    fn point_above(&self, side: SidedFacet, at: ShadedPoint, lift: f64) -> ShadedPoint {
        let sign = if side.front { 1.0 } else { -1.0 };
        let up = self.geometry.facets[side.facet].plate.normal() * sign;
        ShadedPoint { point: at.point + up * lift, normal: at.normal * sign }
    }
    /// Faces of mesh files, and values by face.
    pub fn faces(&self) -> &FaceTable {
        &self.own().faces
    }
    /// Textures.
    pub fn textures(&self) -> &[Texture] {
        &self.own().textures
    }
    /// Panes.
    pub fn panes(&self) -> &[Pane] {
        &self.own().panes
    }
    /// The medium, if any.
    pub fn voxel_grid(&self) -> Option<&VoxelGrid> {
        self.own().voxel_grid.as_ref()
    }
    /// Direct lights.
    pub fn lights(&self) -> &[Light] {
        &self.own().lights
    }
    /// The surroundings.
    pub fn surroundings(&self) -> &Surroundings {
        &self.own().surroundings
    }
    /// True if the temperatures of a solve couple its bands: the scene is not grey and some zone has a known net power, or bodies at one temperature or
    /// convection leave temperatures unknown.
    pub fn couples_bands(&self) -> bool {
        let Some(thermal) = self.thermal() else { return false };
        let open = |k: &ThermalCondition| !matches!(k, ThermalCondition::Temperature(_));
        let cells =
            || self.voxel_grid().is_some_and(|m| (0..m.len()).any(|i| m.heat(i).as_ref().is_some_and(open)));
        !thermal.band_fractions.is_grey()
            && (thermal.surfaces.iter().any(open) || thermal.panes.iter().any(open) || cells())
            || thermal.has_unknown_nodes()
    }
    /// True if the scene is periodic along any axis.
    pub fn is_periodic(&self) -> bool {
        self.periodic() != [false; 3]
    }
    /// Axes along which the scene is periodic, with the medium's extent as period.
    pub fn periodic(&self) -> [bool; 3] {
        self.geometry.periodic
    }
    /// Ends of the boundary box that are symmetry planes, low and high, by axis.
    pub fn symmetry_planes(&self) -> [[bool; 2]; 3] {
        self.geometry.symmetry_planes
    }
    /// True if an end of the boundary box is a symmetry plane.
    pub fn has_symmetry_planes(&self) -> bool {
        self.symmetry_planes() != [[false; 2]; 3]
    }
    /// Axes without an end: periodic ones, and those with symmetry planes at both ends.
    pub fn endless_axes(&self) -> [bool; 3] {
        endless_axes(self.periodic(), self.symmetry_planes())
    }
    /// The axis along which a scene without a medium is periodic: all walls extend along it as infinitely long strips.
    pub fn strip_axis(&self) -> Option<usize> {
        if self.voxel_grid().is_some() { None } else { (0..3).find(|&k| self.periodic()[k]) }
    }
    /// Lower and upper corner of the boundary box, m: the extent of the medium, or the given box of a scene without one.
    pub fn boundary_box(&self) -> Option<(Vec3, Vec3)> {
        extent_or(self.voxel_grid(), self.geometry.boundary_box)
    }
    /// Cameras.
    pub fn cameras(&self) -> &[Camera] {
        &self.geometry.cameras
    }
    /// Settings.
    pub fn options(&self) -> &SolveOptions {
        &self.geometry.options
    }
    /// Whether powers are normalized, and rows of tables scaled, so that closure holds: as set, else in thermal mode only, where missing closure is missing
    /// heat.
    pub fn restores_closure(&self) -> bool {
        self.options().restore_closure.unwrap_or(self.thermal().is_some())
    }
    /// Whether the dense engine restores the closure of its rows: as set, else yes. Factors in closed form stay, sampled ones move within their errors.
    pub fn restores_rows(&self) -> bool {
        self.options().restore_closure.unwrap_or(true)
    }
    /// Notes of the reader.
    pub fn notes(&self) -> &[Diagnostic] {
        &self.geometry.notes
    }
    /// Smallest and largest coordinates of the scene, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.geometry.bounds
    }
    /// Length of the diagonal of the bounds, m.
    pub fn diagonal(&self) -> f64 {
        (self.geometry.bounds.1 - self.geometry.bounds.0).length()
    }
    /// Reflectance of a facet at plate parameters (u, v): that of its face, or texture times factor of the surface, at most 1.
    pub fn reflectance_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        if let Some(own) = self.own().faces.values_of(facet).reflectance {
            return own;
        }
        let f = &self.geometry.facets[facet];
        let s = &self.own().surfaces[f.surface];
        self.textured(s.reflectance, s.reflectance_texture, f.uv_at(u, v)).map(|x| x.min(1.0))
    }
    /// Emitted flux of a facet at plate parameters (u, v), W/m²: that of its face, or texture times factor of the surface.
    pub fn emission_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        if let Some(own) = self.own().faces.values_of(facet).emission {
            return own;
        }
        let f = &self.geometry.facets[facet];
        let s = &self.own().surfaces[f.surface];
        self.textured(s.emission, s.emission_texture, f.uv_at(u, v))
    }
    /// Diffuse transmittance of a facet at plate parameters (u, v): texture times factor of the surface, at most 1 − ρ; zero for an opaque surface.
    pub fn transmittance_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        let f = &self.geometry.facets[facet];
        let Some(own) = self.own().surfaces[f.surface].transmission else { return Bands::ZERO };
        let rest = 1.0 - self.reflectance_at(facet, u, v);
        self.textured(own.transmittance, own.texture, f.uv_at(u, v)).min(rest)
    }
    /// Reflectance of a facet without texture: that of its face, or of its surface.
    pub fn facet_reflectance(&self, facet: usize) -> Bands {
        let own = self.own().faces.values_of(facet).reflectance;
        own.unwrap_or(self.own().surfaces[self.geometry.facets[facet].surface].reflectance)
    }
    /// Reflectance of a patch of a thermal scene at `t` kelvin: that of its face, or of its side of the surface.
    pub fn patch_reflectance(&self, patch: &Patch, t: f64) -> Bands {
        let facet = &self.geometry.facets[patch.facet];
        let emissivities = self.own().thermal.as_ref().map_or(&[][..], |t| &t.emissivities);
        let own = match self.own().faces.values_of(patch.facet).reflectance {
            None => emissivities.get(facet.surface),
            Some(_) => None,
        };
        let Some(own) = own else { return self.facet_reflectance(patch.facet) };
        let at = |side: &SideEmissivity| side.reflectance_at(&self.geometry.bands, self.block(), t);
        match own.back.as_ref().filter(|_| facet.plate.normal().dot(patch.normal) < 0.0) {
            Some(back) => at(back),
            None => at(&SideEmissivity {
                reflectance: self.facet_reflectance(patch.facet),
                table: own.table.clone(),
            }),
        }
    }
    /// Thermal condition of a facet: that of its face, or of its surface; `None` in light mode.
    pub fn facet_condition(&self, facet: usize) -> Option<ThermalCondition> {
        let thermal = self.own().thermal.as_ref()?;
        let own = self.own().faces.values_of(facet).condition;
        own.or_else(|| thermal.surfaces.get(self.geometry.facets[facet].surface).copied())
    }
    /// `factor` times the texture, if any, at texture coordinates `uv`.
    fn textured(&self, factor: Bands, texture: Option<usize>, uv: [f64; 2]) -> Bands {
        match texture {
            None => factor,
            Some(t) => factor * self.own().textures[t].sample(uv),
        }
    }
    /// Largest patch edge of surfaces without a patch size of their own, m.
    pub fn patch_size(&self) -> f64 {
        self.geometry.options.patch_size.unwrap_or(self.diagonal() / DEFAULT_PATCHES_PER_DIAGONAL)
    }
    /// True if the emission of this surface is direct light.
    pub fn is_direct_emitter(&self, surface: usize) -> bool {
        self.own().lights.iter().any(|l| l.surface() == Some(surface))
    }
    /// The scene with other settings.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn with_options(self, options: SolveOptions) -> Result<Scene, SceneError> {
        if self.optics.len() == 1 {
            return Scene::new(SceneParts { options, ..self.into_parts() });
        }
        self.map_blocks(|s| Scene::new(SceneParts { options: options.clone(), ..s.into_parts() }))
    }
    /// The parts of the scene; with its first block of bands if there are several.
    pub fn into_parts(mut self) -> SceneParts {
        let optics = Arc::unwrap_or_clone(self.optics.swap_remove(0));
        SceneParts::joined(Arc::unwrap_or_clone(self.geometry), optics)
    }
}

fn escape_name(name: &mut String) {
    if let Cow::Owned(escaped) = printable(name) {
        *name = escaped;
    }
}
