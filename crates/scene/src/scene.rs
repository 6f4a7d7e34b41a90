//! The scene: validated at construction and read-only afterwards.

use crate::bands::Bands;
use crate::camera::Camera;
use crate::diagnostic::Diagnostic;
use crate::light::{Light, Surroundings};
use crate::options::SolveOptions;
use crate::printable::printable;
use crate::scene_error::SceneError;
use crate::scene_parts::SceneParts;
use crate::surface::{Facet, Pane, Surface, Texture};
use crate::thermal::Thermal;
use crate::validation::check_parts;
use crate::voxel_grid::VoxelGrid;
use std::borrow::Cow;
use zonal_math::Vec3;

/// Patch edges of a scene's diagonal, if no patch size is given.
const DEFAULT_PATCHES_PER_DIAGONAL: f64 = 30.0;

/// A validated scene.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, Sides, Surface};
/// let wall = Surface {
///     name: "wall".into(),
///     reflectance: Bands::splat(0.5),
///     emission: Bands::ONE,
///     reflectance_texture: None,
///     emission_texture: None,
///     sides: Sides::Front,
///     patch_size: None,
///     solid: false,
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
    parts: SceneParts,
    bounds: (Vec3, Vec3),
}

impl Scene {
    /// Validates the parts. Control characters in names are escaped.
    ///
    /// # Errors
    /// If the scene is empty, a value is out of range, an index is invalid or a name is not unique.
    pub fn new(mut parts: SceneParts) -> Result<Scene, SceneError> {
        parts.names_mut().for_each(escape_name);
        check_parts(&parts)?;
        let bounds = parts.bounds();
        Ok(Scene { parts, bounds })
    }

    /// A scene of parts that are valid by construction.
    pub(crate) fn of_checked_parts(parts: SceneParts) -> Scene {
        let bounds = parts.bounds();
        Scene { parts, bounds }
    }

    /// Thermal conditions; `None` in light mode.
    pub fn thermal(&self) -> Option<&Thermal> {
        self.parts.thermal.as_ref()
    }
    /// Name.
    pub fn name(&self) -> &str {
        &self.parts.name
    }
    /// Surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.parts.surfaces
    }
    /// Facets of all surfaces.
    pub fn facets(&self) -> &[Facet] {
        &self.parts.facets
    }
    /// Textures.
    pub fn textures(&self) -> &[Texture] {
        &self.parts.textures
    }
    /// Panes.
    pub fn panes(&self) -> &[Pane] {
        &self.parts.panes
    }
    /// The medium, if any.
    pub fn voxel_grid(&self) -> Option<&VoxelGrid> {
        self.parts.voxel_grid.as_ref()
    }
    /// Direct lights.
    pub fn lights(&self) -> &[Light] {
        &self.parts.lights
    }
    /// The surroundings.
    pub fn surroundings(&self) -> &Surroundings {
        &self.parts.surroundings
    }
    /// True if the scene is periodic along any axis.
    pub fn is_periodic(&self) -> bool {
        self.periodic() != [false; 3]
    }
    /// Axes along which the scene is periodic, with the medium's extent as period.
    pub fn periodic(&self) -> [bool; 3] {
        self.parts.periodic
    }
    /// Ends of the boundary box that are mirrors, low and high, by axis.
    pub fn mirrors(&self) -> [[bool; 2]; 3] {
        self.parts.mirrors
    }
    /// True if an end of the boundary box is a mirror.
    pub fn has_mirrors(&self) -> bool {
        self.mirrors() != [[false; 2]; 3]
    }
    /// Axes without an end: periodic ones, and those with mirrors at both ends.
    pub fn endless_axes(&self) -> [bool; 3] {
        self.parts.endless_axes()
    }
    /// The axis along which a scene without a medium is periodic: all walls extend along it as infinitely long strips.
    pub fn strip_axis(&self) -> Option<usize> {
        if self.voxel_grid().is_some() { None } else { (0..3).find(|&k| self.periodic()[k]) }
    }
    /// Lower and upper corner of the boundary box, m: the extent of the medium, or the given box of a scene without one.
    pub fn boundary_box(&self) -> Option<(Vec3, Vec3)> {
        self.parts.boundary_box()
    }
    /// Cameras.
    pub fn cameras(&self) -> &[Camera] {
        &self.parts.cameras
    }
    /// Settings.
    pub fn options(&self) -> &SolveOptions {
        &self.parts.options
    }
    /// Whether closure is restored: as set, else in thermal mode only, where missing closure is missing heat.
    pub fn restores_closure(&self) -> bool {
        self.options().restore_closure.unwrap_or(self.thermal().is_some())
    }
    /// Notes of the reader.
    pub fn notes(&self) -> &[Diagnostic] {
        &self.parts.notes
    }
    /// Smallest and largest coordinates of the scene, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
    /// Length of the diagonal of the bounds, m.
    pub fn diagonal(&self) -> f64 {
        (self.bounds.1 - self.bounds.0).length()
    }
    /// Reflectance of a facet at plate parameters (u, v): texture times factor of the surface, at most 1.
    pub fn reflectance_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        let f = &self.parts.facets[facet];
        let s = &self.parts.surfaces[f.surface];
        self.textured(s.reflectance, s.reflectance_texture, f.uv_at(u, v)).map(|x| x.min(1.0))
    }
    /// Emitted flux of a facet at plate parameters (u, v), W/m².
    pub fn emission_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        let f = &self.parts.facets[facet];
        let s = &self.parts.surfaces[f.surface];
        self.textured(s.emission, s.emission_texture, f.uv_at(u, v))
    }
    /// `factor` times the texture, if any, at texture coordinates `uv`.
    fn textured(&self, factor: Bands, texture: Option<usize>, uv: [f64; 2]) -> Bands {
        match texture {
            None => factor,
            Some(t) => factor * self.parts.textures[t].sample(uv),
        }
    }
    /// Largest patch edge of surfaces without a patch size of their own, m.
    pub fn patch_size(&self) -> f64 {
        self.parts.options.patch_size.unwrap_or(self.diagonal() / DEFAULT_PATCHES_PER_DIAGONAL)
    }
    /// True if the emission of this surface is direct light.
    pub fn is_direct_emitter(&self, surface: usize) -> bool {
        self.parts.lights.iter().any(|l| matches!(l, Light::Emitter { surface: s, .. } if *s == surface))
    }
    /// The scene with other settings.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn with_options(mut self, options: SolveOptions) -> Result<Scene, SceneError> {
        self.parts.options = options;
        Scene::new(self.parts)
    }
    /// The parts of the scene.
    pub fn into_parts(self) -> SceneParts {
        self.parts
    }
}

fn escape_name(name: &mut String) {
    if let Cow::Owned(escaped) = printable(name) {
        *name = escaped;
    }
}
