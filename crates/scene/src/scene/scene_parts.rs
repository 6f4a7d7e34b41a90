//! The parts of a scene before validation.

use crate::bands::band_set::BandSet;
use crate::base::diagnostic::Diagnostic;
use crate::geometry::plate::Plate;
use crate::medium::voxel_grid::VoxelGrid;
use crate::model::camera::Camera;
use crate::model::face_table::FaceTable;
use crate::model::light::{Light, Surroundings};
use crate::model::options::SolveOptions;
use crate::model::shading::ShadingNormals;
use crate::model::surface::{Facet, Pane, Surface, Texture};
use crate::thermal::Thermal;
use zonal_math::Vec3;

/// The parts of a scene, not yet validated.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name.
    pub name: String,
    /// Surfaces.
    pub surfaces: Vec<Surface>,
    /// Facets of all surfaces.
    pub facets: Vec<Facet>,
    /// Normals for pictures of facets that stand for curved surfaces.
    pub shading: ShadingNormals,
    /// Faces of mesh files, and values by face.
    pub faces: FaceTable,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Panes.
    pub panes: Vec<Pane>,
    /// The medium; `None` for vacuum.
    pub voxel_grid: Option<VoxelGrid>,
    /// Direct lights.
    pub lights: Vec<Light>,
    /// The surroundings.
    pub surroundings: Surroundings,
    /// Axes along which the scene is periodic, with the medium's extent as period.
    pub periodic: [bool; 3],
    /// Ends of the boundary box that are symmetry planes, low and high, by axis.
    pub symmetry_planes: [[bool; 2]; 3],
    /// Lower and upper corner of the boundary box of a scene without a medium, m; with a medium the box is the medium's extent.
    pub boundary_box: Option<(Vec3, Vec3)>,
    /// Thermal conditions; `None` in light mode.
    pub thermal: Option<Thermal>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// The bands of the whole scene.
    pub bands: BandSet,
    /// The block of up to three bands that these parts describe.
    pub block: usize,
    /// Settings.
    pub options: SolveOptions,
    /// Notes of the reader, such as dropped triangles.
    pub notes: Vec<Diagnostic>,
}

/// Divides the parts of a scene into what is common to all bands and what has optical properties. A part that is not named here does not compile.
macro_rules! division {
    (geometry { $($common:ident: $of_common:ty,)+ } optics { $($own:ident: $of_own:ty,)+ }) => {
        /// Data common to all bands of a scene.
        #[derive(Clone, Debug)]
        pub(crate) struct SceneGeometry {
            $(pub(crate) $common: $of_common,)+
            /// Smallest and largest coordinates, m.
            pub(crate) bounds: (Vec3, Vec3),
        }

        /// Objects with optical properties, in one block of bands.
        #[derive(Clone, Debug)]
        pub(crate) struct BlockOptics {
            $(pub(crate) $own: $of_own,)+
        }

        impl SceneParts {
            /// The geometry and the optical properties.
            pub(crate) fn divided(self) -> (SceneGeometry, BlockOptics) {
                let bounds = self.bounds();
                let SceneParts { $($common,)+ $($own,)+ } = self;
                (SceneGeometry { $($common,)+ bounds }, BlockOptics { $($own,)+ })
            }

            /// The parts of a geometry and optical properties.
            pub(crate) fn joined(geometry: SceneGeometry, optics: BlockOptics) -> SceneParts {
                SceneParts { $($common: geometry.$common,)+ $($own: optics.$own,)+ }
            }
        }
    };
}

division! {
    geometry {
        name: String,
        facets: Vec<Facet>,
        shading: ShadingNormals,
        periodic: [bool; 3],
        symmetry_planes: [[bool; 2]; 3],
        boundary_box: Option<(Vec3, Vec3)>,
        cameras: Vec<Camera>,
        bands: BandSet,
        options: SolveOptions,
        notes: Vec<Diagnostic>,
    }
    optics {
        surfaces: Vec<Surface>,
        faces: FaceTable,
        textures: Vec<Texture>,
        panes: Vec<Pane>,
        voxel_grid: Option<VoxelGrid>,
        lights: Vec<Light>,
        surroundings: Surroundings,
        thermal: Option<Thermal>,
        block: usize,
    }
}

impl SceneParts {
    /// Gives a grey scene in thermal mode its one band in place of red, green and blue.
    pub(crate) fn give_grey_band(&mut self) {
        let is_grey = self.thermal.as_ref().is_some_and(|t| t.band_fractions.is_grey());
        if is_grey && self.bands.is_rgb() {
            self.bands = BandSet::grey();
        }
    }

    /// All names, for editing.
    pub(crate) fn names_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let lights = self.lights.iter_mut().filter_map(Light::name_mut);
        let surroundings = self.surroundings.name.as_mut().into_iter();
        std::iter::once(&mut self.name)
            .chain(self.surfaces.iter_mut().map(|s| &mut s.name))
            .chain(self.panes.iter_mut().map(|p| &mut p.name))
            .chain(self.cameras.iter_mut().map(|c| &mut c.name))
            .chain(lights)
            .chain(surroundings)
    }

    /// Lower and upper corner of the boundary box, m.
    pub(crate) fn boundary_box(&self) -> Option<(Vec3, Vec3)> {
        extent_or(self.voxel_grid.as_ref(), self.boundary_box)
    }

    /// Gives the cells of a grid of other size the band fractions of the cells of the old grid at their centres.
    pub(crate) fn resample_cell_fractions(&mut self, old: Option<&VoxelGrid>) {
        let own = self.thermal.as_mut().and_then(|t| t.cell_fractions.as_mut());
        let (Some(own), Some(old), Some(new)) = (own, old, &self.voxel_grid) else { return };
        let at = |k: usize, c: usize| (2 * c + 1) * old.dims()[k] / (2 * new.dims()[k]);
        let cell = |i: usize| {
            let c = new.coordinates(i);
            old.index([0, 1, 2].map(|k| at(k, c[k])))
        };
        own.kind_of_cell = (0..new.len()).map(|i| own.kind_of_cell[cell(i)]).collect();
    }

    /// Smallest and largest coordinates of all facets, panes and the voxel grid, m.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
        let plates = self.facets.iter().map(|f| &f.plate).chain(self.panes.iter().flat_map(|p| &p.plates));
        for (lo, hi) in plates.map(Plate::bounds).chain(self.voxel_grid.iter().map(|v| (v.min(), v.max()))) {
            bounds = (bounds.0.min(lo), bounds.1.max(hi));
        }
        bounds
    }
}

/// The extent of a medium, m, or without one the given box.
pub(crate) fn extent_or(grid: Option<&VoxelGrid>, given: Option<(Vec3, Vec3)>) -> Option<(Vec3, Vec3)> {
    grid.map(|v| (v.min(), v.max())).or(given)
}

/// Axes without an end: periodic ones, and those with symmetry planes at both ends.
pub(crate) fn endless_axes(periodic: [bool; 3], symmetry_planes: [[bool; 2]; 3]) -> [bool; 3] {
    std::array::from_fn(|k| periodic[k] || symmetry_planes[k] == [true; 2])
}
