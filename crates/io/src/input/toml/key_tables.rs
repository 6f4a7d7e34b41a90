//! The tables of the scene format: [`SCENE_TABLES`] lists them, and [`scene_key_reference`] their keys for manuals. Defined here are the keys of the
//! document, `[solve]` and `[boundary]`; the modules beside this one define the others.
//!
//! Types: *bands* is one number for all bands or a list of one for each, by default `[red, green, blue]`; *point* and *direction* are `[x, y, z]`.

use super::camera_keys::Camera;
use super::key_specs::{KeyGroups, all};
use super::keys::{Kind, keys};
use super::kinds::{BOOLEAN, COUNT, FRACTION, LENGTH, POINT, TABLE, TABLES, TEXT, one_of, shown, words};
use super::light_keys::{Emitter, Luminaire, Planet, PointLight, Spot, Sun, Surroundings, Tube};
use super::medium_keys::{DensityFile, Gas, MaterialPane, Medium, Pane, Region, VoxelFile};
use super::sky_keys::{CieSky, ImageSky, PerezSky, Sky};
use super::spectrum_keys::Spectrum;
use super::surface_keys::{
    Bounds, Box, Faces, Material, PlacedMesh, Rectangle, Surface, SurfaceMesh, Triangle, ValueFile,
};
use super::thermal_keys::{Back, EmissivityByTemperature, Node, NodeLink, Thermal};
use zonal_math::Vec3;
use zonal_scene::{Engine, LightGrouping, PatchRule, ZoneBasis};

keys! {
    /// The document.
    ROOT: Root = [Root] {
        name: String = TEXT, "the file's name", "name of the scene";
        mode: usize = words!("light", "thermal"), "\"light\"", "radiation from given sources, or temperatures and heat";
        bands: () = shown("integer from 1 to 128, or a list of [number, number]", "nm"), "red, green and blue",
            "number of bands, or the limits of their wavelengths";
        thermal: () = TABLE, "grey", "band fractions of the emission in thermal mode";
        solve: () = TABLE, "", "settings of the solver";
        surface: () = TABLES, "", "surfaces";
        node: () = TABLES, "", "bodies at one temperature (thermal mode)";
        pane: () = TABLES, "", "thin sheets of absorbing and scattering material";
        medium: () = TABLE, "vacuum", "participating medium on a voxel grid";
        boundary: () = TABLE, "", "periodic axes and symmetry planes";
        light: () = TABLES, "", "direct lights";
        surroundings: () = TABLE, "black and cold", "radiation that enters from beyond the scene";
        camera: () = TABLES, "", "cameras";
    }
    /// `[solve]`.
    SOLVE: Solve = [Solve] {
        tolerance: f64 = FRACTION, "0.01", "relative accuracy of the exchange areas";
        patch_size: f64 = LENGTH, "diagonal / 30", "target edge of a patch";
        patch_rule: PatchRule = one_of!(PatchRule), "\"area\" with a mesh file, else \"edge\"", "quantity that the patch size limits";
        closure: usize = words!("measure", "restore"),
            "\"restore\" in thermal mode and for the factors of the dense engine, else \"measure\"", "treatment of row sums that miss closure";
        residual: f64 = FRACTION, "1e-10", "power left undistributed by the iteration, relative to the power of the sources";
        max_iterations: usize = COUNT, "500", "largest number of iterations";
        scattering_orders: usize = COUNT, "", "number of terms of the Neumann series that replace the iteration";
        engine: Engine = one_of!(Engine), "\"auto\"", "representation of the exchange operator";
        light_groups: LightGrouping = one_of!(LightGrouping), "\"auto\"", "light groups that are solved and stored separately";
        zone_basis: ZoneBasis = one_of!(ZoneBasis), "\"auto\"", "basis functions of the radiosity in optically thick voxels";
        discretization_error: bool = BOOLEAN, "true in thermal mode, else false",
            "estimates the discretization error by a second solve on coarser zones";
    }
    /// `[boundary]`.
    BOUNDARY: Boundary = [Boundary] {
        x: usize = BOTH_ENDS, "\"scene\"", "boundary condition along x";
        y: usize = BOTH_ENDS, "\"scene\"", "boundary condition along y";
        z: usize = BOTH_ENDS, "\"scene\"", "boundary condition along z";
        x0: usize = ONE_END, "that of x", "boundary condition at the low end of x";
        x1: usize = ONE_END, "that of x", "boundary condition at the high end of x";
        y0: usize = ONE_END, "that of y", "boundary condition at the low end of y";
        y1: usize = ONE_END, "that of y", "boundary condition at the high end of y";
        z0: usize = ONE_END, "that of z", "boundary condition at the low end of z";
        z1: usize = ONE_END, "that of z", "boundary condition at the high end of z";
        min: Vec3 = POINT, "that of the medium", "lower corner of the boundary of a scene without a medium";
        max: Vec3 = POINT, "that of the medium", "upper corner of the boundary of a scene without a medium";
    }
}
const BOTH_ENDS: Kind<usize> = words!("symmetry", "periodic", "scene");
const ONE_END: Kind<usize> = words!("symmetry", "scene");

/// The tables of the scene format by path; `[]` marks lists, capitals a free name.
pub(crate) const SCENE_TABLES: &[(&str, KeyGroups)] = &[
    ("", Root::TABLE),
    ("thermal", Thermal::TABLE),
    ("solve", Solve::TABLE),
    ("boundary", Boundary::TABLE),
    ("surroundings", Surroundings::TABLE),
    ("surface[]", Surface::TABLE),
    ("node[]", Node::TABLE),
    ("node[].links[]", NodeLink::TABLE),
    ("surface[].rectangle", Rectangle::TABLE),
    ("surface[].triangle", Triangle::TABLE),
    ("surface[].box", Box::TABLE),
    ("surface[].room", Bounds::TABLE),
    ("surface[].mesh", SurfaceMesh::TABLE),
    ("surface[].temperature, … of a mesh", ValueFile::TABLE),
    ("surface[].emissivity by temperature", EmissivityByTemperature::TABLE),
    ("surface[].back", Back::TABLE),
    ("surface[].faces", Faces::TABLE),
    ("surface[].materials.NAME", Material::TABLE),
    ("surface[].materials.NAME.pane", MaterialPane::TABLE),
    ("pane[]", Pane::TABLE),
    ("medium", Medium::TABLE),
    ("medium.ARRAY", VoxelFile::TABLE),
    ("medium.gas", Gas::TABLE),
    ("medium.gas.ARRAY", VoxelFile::TABLE),
    ("medium.region[]", Region::TABLE),
    ("medium.region[].box", Bounds::TABLE),
    ("medium.region[].mesh", PlacedMesh::TABLE),
    ("medium.region[].density", DensityFile::TABLE),
    ("medium.region[].ARRAY", VoxelFile::TABLE),
    ("medium.region[].gas", Gas::TABLE),
    ("medium.region[].gas.ARRAY", VoxelFile::TABLE),
    ("light[] (sun)", Sun::TABLE),
    ("light[] (sky)", Sky::TABLE),
    ("light[] (cie-sky)", CieSky::TABLE),
    ("light[] (perez-sky)", PerezSky::TABLE),
    ("light[] (image-sky)", ImageSky::TABLE),
    ("light[] (emitter)", Emitter::TABLE),
    ("light[] (planet)", Planet::TABLE),
    ("light[] (point)", PointLight::TABLE),
    ("light[] (spot)", Spot::TABLE),
    ("light[] (tube)", Tube::TABLE),
    ("light[] (luminaire)", Luminaire::TABLE),
    ("SPECTRUM", Spectrum::TABLE),
    ("camera[]", Camera::TABLE),
];

/// A key of the scene format, for manuals and editors.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneKey {
    /// Dotted path; `[]` marks the entries of a list, capitals stand for a free name.
    pub path: String,
    /// Type of the value.
    pub value: String,
    /// Unit; empty for none.
    pub unit: &'static str,
    /// Default, or `required`; empty if the key then does not apply.
    pub default: &'static str,
    /// One line.
    pub description: &'static str,
}

/// All keys of the scene format, in the order of the manual. The reader checks scenes against the same tables.
///
/// ```
/// let keys = zonal_io::input::scene_key_reference();
/// let tolerance = keys.iter().find(|k| k.path == "solve.tolerance").unwrap();
/// assert_eq!(tolerance.default, "0.01");
/// ```
pub fn scene_key_reference() -> Vec<SceneKey> {
    let rows = SCENE_TABLES.iter().flat_map(|(table, groups)| all(groups).map(move |k| (table, k)));
    rows.map(|(table, k)| SceneKey {
        path: if table.is_empty() { k.name.to_string() } else { format!("{table}.{}", k.name) },
        value: k.value.text(),
        unit: k.unit,
        default: k.default,
        description: k.description,
    })
    .collect()
}
