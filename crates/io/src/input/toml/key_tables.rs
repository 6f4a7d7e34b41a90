//! Every key of the scene and camera-path formats, defined once: the readers check unknown keys against these tables, and
//! [`scene_key_reference`] lists them for manuals.
//!
//! Types: *bands* is one number for all bands or a list of one for each, by default `[red, green, blue]`; *point* and *direction* are `[x, y, z]`.

use super::camera_keys::CAMERA;
use super::keys::{KeyGroups, KeySpec, all, key};
use super::light_keys::{EMITTER, LUMINAIRE, PLANET, POINT, SPECTRUM, SPOT, SUN, SURROUNDINGS, TUBE};
use super::sky_keys::{CIE_SKY, IMAGE_SKY, PEREZ_SKY, SKY};
use super::thermal_keys::{BACK_OF_SURFACE, EMISSIVITY_BY_TEMPERATURE, NODE, NODE_LINK, THERMAL};

const ROOT_KEYS: &[KeySpec] = &[
    key("name", "text", "", "the file's name", "name of the scene"),
    key(
        "mode",
        "\"light\" | \"thermal\"",
        "",
        "\"light\"",
        "radiation from given sources, or temperatures and heat",
    ),
    key(
        "bands",
        "integer from 1 to 128, or a list of [number, number]",
        "nm",
        "red, green and blue",
        "number of bands, or the limits of their wavelengths",
    ),
    key("thermal", "table", "", "grey", "band fractions of the emission in thermal mode"),
    key("solve", "table", "", "", "settings of the solver"),
    key("surface", "list of tables", "", "", "surfaces"),
    key("node", "list of tables", "", "", "bodies at one temperature (thermal mode)"),
    key("pane", "list of tables", "", "", "thin sheets of absorbing and scattering material"),
    key("medium", "table", "", "vacuum", "participating medium on a voxel grid"),
    key("boundary", "table", "", "", "periodic axes and symmetry planes"),
    key("light", "list of tables", "", "", "direct lights"),
    key("surroundings", "table", "", "black and cold", "radiation that enters from beyond the scene"),
    key("camera", "list of tables", "", "", "cameras"),
];
/// The document.
pub(crate) const ROOT: KeyGroups = &[ROOT_KEYS];

/// `[solve]`.
pub(crate) const SOLVE: KeyGroups = &[&[
    key("tolerance", "number in (0, 1)", "", "0.01", "relative accuracy of the exchange areas"),
    key("patch_size", "number above 0", "m", "diagonal / 30", "target edge of a patch"),
    key(
        "patch_rule",
        "\"edge\" | \"area\" | \"voxels\"",
        "",
        "\"area\" with a mesh file, else \"edge\"",
        "quantity that the patch size limits",
    ),
    key(
        "closure",
        "\"measure\" | \"restore\"",
        "",
        "\"restore\" in thermal mode and for the factors of the dense engine, else \"measure\"",
        "treatment of row sums that miss closure",
    ),
    key(
        "residual",
        "number in (0, 1)",
        "",
        "1e-10",
        "power left undistributed by the iteration, relative to the power of the sources",
    ),
    key("max_iterations", "integer from 1", "", "500", "largest number of iterations"),
    key(
        "scattering_orders",
        "integer from 1",
        "",
        "",
        "number of terms of the Neumann series that replace the iteration",
    ),
    key(
        "engine",
        "\"auto\" | \"dense\" | \"rays\" | \"spectral\" | \"layered\"",
        "",
        "\"auto\"",
        "representation of the exchange operator",
    ),
    key(
        "light_groups",
        "\"auto\" | \"each\" | \"all\"",
        "",
        "\"auto\"",
        "light groups that are solved and stored separately",
    ),
    key(
        "zone_basis",
        "\"auto\" | \"linear\" | \"constant\"",
        "",
        "\"auto\"",
        "basis functions of the radiosity in optically thick voxels",
    ),
    key(
        "discretization_error",
        "boolean",
        "",
        "true in thermal mode, else false",
        "estimates the discretization error by a second solve on coarser zones",
    ),
]];

/// `[boundary]`.
pub(crate) const BOUNDARY: KeyGroups = &[&[
    key("x", BOTH_ENDS, "", "\"scene\"", "boundary condition along x"),
    key("y", BOTH_ENDS, "", "\"scene\"", "boundary condition along y"),
    key("z", BOTH_ENDS, "", "\"scene\"", "boundary condition along z"),
    key("x0", ONE_END, "", "that of x", "boundary condition at the low end of x"),
    key("x1", ONE_END, "", "that of x", "boundary condition at the high end of x"),
    key("y0", ONE_END, "", "that of y", "boundary condition at the low end of y"),
    key("y1", ONE_END, "", "that of y", "boundary condition at the high end of y"),
    key("z0", ONE_END, "", "that of z", "boundary condition at the low end of z"),
    key("z1", ONE_END, "", "that of z", "boundary condition at the high end of z"),
    key(
        "min",
        "point",
        "m",
        "that of the medium",
        "lower corner of the boundary of a scene without a medium",
    ),
    key(
        "max",
        "point",
        "m",
        "that of the medium",
        "upper corner of the boundary of a scene without a medium",
    ),
]];
const BOTH_ENDS: &str = "\"symmetry\" | \"periodic\" | \"scene\"";
const ONE_END: &str = "\"symmetry\" | \"scene\"";

const SURFACE_KEYS: &[KeySpec] = &[
    key("name", "text", "", "surface1, …", "unique name"),
    key(
        "faces",
        "table of faces",
        "",
        "",
        "properties of single faces x0, x1, y0, y1, z0, z1 of a box or room",
    ),
    key("omit", "list of faces", "", "[]", "walls that a room lacks"),
    key("materials", "table of materials", "", "", "properties of single materials of a mesh"),
    key("solid", "boolean", "", "true", "treats closed parts of a mesh as solids and rooms"),
    key(
        "open_sides",
        "\"file\" | \"both\"",
        "",
        "\"file\"",
        "sides of the open parts of a mesh; with \"both\", parts that are turned inside out count as open",
    ),
    key("lights", "boolean", "", "true", "adds the lights of a glTF mesh to the scene (light mode)"),
];
/// The shapes of a surface, of which one is given.
pub(crate) const SURFACE_SHAPES: &[KeySpec] = &[
    key("rectangle", "table", "", "", "parallelogram; the front faces edge1 × edge2"),
    key("triangle", "table", "", "", "triangle; its front sees the corners counter-clockwise"),
    key("box", "table", "", "", "solid box with outward normals"),
    key("room", "table", "", "", "six walls with inward normals"),
    key("mesh", "table", "", "", "mesh file: OBJ, STL, PLY, GLB, glTF, MSH, VTU or VTP"),
];
/// Properties of a surface, of a face or of a material.
pub(crate) const SURFACE_PROPERTIES: &[KeySpec] = &[
    key("reflectance", "bands in [0, 1]", "", "0.5, or the mesh's", "diffuse reflectance"),
    key(
        "transmittance",
        "bands in [0, 1]",
        "",
        "0, or the mesh's",
        "diffuse transmittance of a thin sheet, from each side to the other (light mode)",
    ),
    key(
        "emission",
        "bands from 0",
        "W/m2",
        "0, or the mesh's",
        "emitted flux; in thermal mode light of an emitter, a number",
    ),
    key(
        "sides",
        "\"front\" | \"both\"",
        "",
        "\"front\"; of open meshes by their file",
        "sides that take part in the exchange",
    ),
    key("patch_size", "number above 0", "m", "that of [solve]", "target edge of a patch"),
    key("texture", "file name", "", "", "PNG or JPEG that multiplies the reflectance (light mode)"),
    key(
        "emissivity",
        "bands in [0, 1] | table",
        "",
        "1 - reflectance",
        "diffuse emissivity, in place of the reflectance",
    ),
    key(
        "solar_absorptance",
        "number in [0, 1]",
        "",
        "the emissivity",
        "absorbed fraction of sunlight (thermal mode with lights)",
    ),
    key("back", "table", "", "as the front", "emissivity of the back, with sides = \"both\" (thermal mode)"),
    key("temperature", "number above 0", "K", "", "given temperature (thermal mode)"),
    key("heat_flux", "number", "W/m2", "", "given net radiative flux that leaves the surface (thermal mode)"),
    key("net_power", "number", "W", "", "given net power that leaves the whole surface (thermal mode)"),
    key("node", "text", "", "", "name of the [[node]] whose temperature the surface has (thermal mode)"),
    key(
        "heat_transfer_coefficient",
        "number from 0",
        "W/(m2 K)",
        "",
        "convection to air of ambient_temperature (thermal mode)",
    ),
    key("ambient_temperature", "number above 0", "K", "", "temperature of the air (thermal mode)"),
];
/// `temperature`, `heat_flux`, `net_power`, `emissivity`, `reflectance` or `emission` of a mesh from a file.
pub(crate) const VALUE_FILE: KeyGroups = &[&[
    key("file", "file name", "", "required", ".csv, .npy, .vtu or .vtp"),
    key(
        "column",
        "text | integer from 1",
        "",
        "the only one, or the one named like the quantity",
        "column of the table by name or number, or array of cell data",
    ),
    key(
        "by",
        "\"face\" | \"material\"",
        "",
        "\"face\"",
        "one row for each face of the mesh file in its order, or rows of a material's name and its value",
    ),
]];

/// `[[surface]]`.
pub(crate) const SURFACE: KeyGroups = &[SURFACE_KEYS, SURFACE_SHAPES, SURFACE_PROPERTIES];
/// One face of a box or room.
pub(crate) const FACE: KeyGroups = &[SURFACE_PROPERTIES];

const FACE_TABLE: &str = "properties as of a surface";
/// `faces`.
pub(crate) const FACES: KeyGroups = &[&[
    key("x0", "table", "", "", FACE_TABLE),
    key("x1", "table", "", "", FACE_TABLE),
    key("y0", "table", "", "", FACE_TABLE),
    key("y1", "table", "", "", FACE_TABLE),
    key("z0", "table", "", "", FACE_TABLE),
    key("z1", "table", "", "", FACE_TABLE),
]];

/// `rectangle`.
pub(crate) const RECTANGLE: KeyGroups = &[&[
    key("origin", "point", "m", "required", "corner"),
    key("edge1", "direction", "m", "required", "first edge from the corner"),
    key("edge2", "direction", "m", "required", "second edge from the corner"),
]];
/// `triangle`.
pub(crate) const TRIANGLE: KeyGroups =
    &[&[key("corners", "three points", "m", "required", "corners, counter-clockwise seen from the front")]];
const BOUNDS_KEYS: &[KeySpec] = &[
    key("min", "point", "m", "required", "smallest corner"),
    key("max", "point", "m", "required", "largest corner"),
];
/// `room`, and `box` of a region.
pub(crate) const BOUNDS: KeyGroups = &[BOUNDS_KEYS];
/// `box` of a surface.
pub(crate) const BOX: KeyGroups = &[
    BOUNDS_KEYS,
    &[key("rotate_z_degrees", "number", "degrees", "0", "rotation about the vertical through the centre")],
];
/// Keys of every placed mesh.
const PLACED_MESH_KEYS: &[KeySpec] = &[
    key("file", "file name", "", "required", ".obj, .stl, .ply, .glb, .gltf, .msh, .vtu or .vtp"),
    key("scale", "number above 0", "m per unit of the file", "1", "factor of lengths"),
    key("translate", "direction", "m", "[0, 0, 0]", "translation after scale and rotation"),
    key(
        "rotate_degrees",
        "[number, number, number]",
        "degrees",
        "[0, 0, 0]",
        "rotations about x, then y, then z",
    ),
];
/// `mesh` of a region.
pub(crate) const MESH: KeyGroups = &[PLACED_MESH_KEYS];
/// `mesh` of a surface.
pub(crate) const SURFACE_MESH: KeyGroups = &[
    PLACED_MESH_KEYS,
    &[key(
        "normals",
        "\"file\" | \"flat\"",
        "",
        "\"file\"",
        "shading of pictures: by the vertex normals and normal maps of the file, or of flat faces; solves see flat faces",
    )],
];

/// `materials.NAME`.
pub(crate) const MATERIAL: KeyGroups = &[
    &[
        key(
            "pane",
            "table | boolean",
            "",
            "as the file says",
            "makes the material a pane, or with false an opaque surface",
        ),
        key("omit", "boolean", "", "false", "leaves the material out"),
        key(
            "region",
            "boolean",
            "",
            "false",
            "fills the medium inside the closed material with its extinction",
        ),
    ],
    SURFACE_PROPERTIES,
];
/// `materials.NAME.pane`.
pub(crate) const MATERIAL_PANE: KeyGroups = &[&[
    key("thickness", "number above 0", "m", "the file's", "thickness"),
    key("extinction", "bands from 0", "1/m", "the file's", "extinction coefficient"),
    key("albedo", "bands in [0, 1]", "", "the file's", "scattering albedo"),
    key(
        "solar_extinction",
        "number from 0",
        "1/m",
        "the extinction",
        "extinction of sunlight (thermal mode with lights)",
    ),
    key(
        "solar_albedo",
        "number in [0, 1]",
        "",
        "the albedo",
        "albedo of sunlight (thermal mode with lights)",
    ),
    key("emission", "bands from 0", "W/m2", "0", "black emissive power (light mode)"),
    key("temperature", "number above 0", "K", "", "given temperature (thermal mode)"),
    key("heat_source", "0", "W/m3", "0", "radiative equilibrium (thermal mode)"),
]];

/// `[[pane]]`.
pub(crate) const PANE: KeyGroups = &[&[
    key("name", "text", "", "pane1, …", "name"),
    key("polygon", "list of points", "m", "required", "corners in order; plane and convex"),
    key("thickness", "number above 0", "m", "required", "thickness"),
    key("extinction", "bands from 0", "1/m", "required", "extinction coefficient"),
    key("albedo", "bands in [0, 1]", "", "0", "scattering albedo"),
    key("emission", "bands from 0", "W/m2", "0", "black emissive power (light mode)"),
    key("absorption", "bands from 0", "1/m", "", "extinction × (1 - albedo), in place of one of them"),
    key(
        "solar_extinction",
        "number from 0",
        "1/m",
        "the extinction",
        "extinction of sunlight (thermal mode with lights)",
    ),
    key(
        "solar_albedo",
        "number in [0, 1]",
        "",
        "the albedo",
        "albedo of sunlight (thermal mode with lights)",
    ),
    key("temperature", "number above 0", "K", "", "given temperature (thermal mode)"),
    key("heat_source", "0", "W/m3", "0", "radiative equilibrium (thermal mode)"),
]];

/// Properties of a medium or region.
pub(crate) const MEDIUM_PROPERTIES: &[KeySpec] = &[
    key("extinction", "bands from 0", "1/m", "0 with regions, else required", "extinction coefficient"),
    key("albedo", "bands in [0, 1] | array", "", "0", "scattering albedo"),
    key("emission", "bands from 0 | array", "W/m2", "0", "black emissive power (light mode)"),
    key("source", "bands from 0", "W/m3", "0", "volumetric source (light mode)"),
    key("absorption", "bands from 0", "1/m", "", "extinction × (1 - albedo), in place of one of them"),
    key(
        "solar_extinction",
        "number from 0",
        "1/m",
        "the extinction",
        "extinction of sunlight (thermal mode with lights)",
    ),
    key(
        "solar_albedo",
        "number in [0, 1]",
        "",
        "the albedo",
        "albedo of sunlight (thermal mode with lights)",
    ),
    key("temperature", "number above 0 | array", "K", "", "given temperature (thermal mode)"),
    key(
        "heat_source",
        "number | array",
        "W/m3",
        "",
        "given heat source; 0 is radiative equilibrium (thermal mode)",
    ),
    key("gas", "table", "", "", "gas model that gives absorption and band fractions (thermal mode)"),
];
const MEDIUM_KEYS: &[KeySpec] = &[
    key("cells", "[integer, integer, integer]", "", "or cell_size", "voxels along each axis"),
    key(
        "cell_size",
        "number | [number, number, number]",
        "m",
        "or cells",
        "edge of a voxel, rounded to whole voxels",
    ),
    key("region", "list of tables", "", "", "parts with other properties, each over those before it"),
];
/// `[medium]`.
pub(crate) const MEDIUM: KeyGroups = &[BOUNDS_KEYS, MEDIUM_KEYS, MEDIUM_PROPERTIES];
/// `[[medium.region]]`.
pub(crate) const REGION: KeyGroups = &[
    &[
        key("box", "table", "", "", "box; voxels that it cuts are mixed by volume"),
        key("mesh", "table", "", "", "voxels whose centre lies inside a closed mesh"),
        key("density", "table", "", "", "extinction from a file"),
    ],
    MEDIUM_PROPERTIES,
];
/// Placement of an OpenVDB grid.
pub(crate) const VDB_KEYS: &[KeySpec] = &[
    key("grid", "text", "", "the only grid, or \"density\"", "grid of an OpenVDB file"),
    key("unit", "number above 0", "m", "1", "length unit of an OpenVDB file"),
    key("translate", "direction", "m", "[0, 0, 0]", "translation of an OpenVDB grid"),
    key(
        "rotate_degrees",
        "[number, number, number]",
        "degrees",
        "[0, 0, 0]",
        "rotations of an OpenVDB grid about x, then y, then z",
    ),
    key("level_set", "boolean", "", "false", "reads a level set as the density 1 inside its surface"),
];
/// Arrays of medium properties, and what a density has in common with them.
const ARRAY_FILE: &[KeySpec] = &[
    key("file", "file name", "", "required", ".npy, .vdb or .vol"),
    key("min", "point", "m", "the file's box", "smallest corner of the box that the array fills"),
    key("max", "point", "m", "the file's box", "largest corner of the box that the array fills"),
    key("scale", "bands from 0", "that of the quantity", "1", "factor of the values"),
];
/// Arrays of medium properties.
pub(crate) const VOXEL_FILE: KeyGroups = &[ARRAY_FILE, VDB_KEYS];
/// `density`.
pub(crate) const DENSITY_FILE: KeyGroups = &[
    ARRAY_FILE,
    &[key(
        "interpolation",
        "\"linear\" | \"constant\"",
        "",
        "\"linear\"",
        "field between the values of a density: trilinear, or constant over each element",
    )],
    VDB_KEYS,
];

/// `gas` of a medium or region.
pub(crate) const GAS: KeyGroups = &[&[
    key("model", "name of a gas model", "", "required", "model: zonal gas --help lists the names"),
    key("h2o", "number from 0 to 1, or array", "", "0", "mole fraction of water vapour"),
    key("co2", "number from 0 to 1, or array", "", "0", "mole fraction of carbon dioxide"),
    key("soot", "number from 0 to 1, or array", "", "0", "volume fraction of soot"),
    key("pressure", "number above 0, or array", "Pa", "101325", "total pressure"),
]];

/// The tables of the scene format by path; `[]` marks lists, capitals a free name.
pub(crate) const SCENE_TABLES: &[(&str, KeyGroups)] = &[
    ("", ROOT),
    ("thermal", THERMAL),
    ("solve", SOLVE),
    ("boundary", BOUNDARY),
    ("surroundings", SURROUNDINGS),
    ("surface[]", SURFACE),
    ("node[]", NODE),
    ("node[].links[]", NODE_LINK),
    ("surface[].rectangle", RECTANGLE),
    ("surface[].triangle", TRIANGLE),
    ("surface[].box", BOX),
    ("surface[].room", BOUNDS),
    ("surface[].mesh", SURFACE_MESH),
    ("surface[].temperature, … of a mesh", VALUE_FILE),
    ("surface[].emissivity by temperature", EMISSIVITY_BY_TEMPERATURE),
    ("surface[].back", BACK_OF_SURFACE),
    ("surface[].faces", FACES),
    ("surface[].materials.NAME", MATERIAL),
    ("surface[].materials.NAME.pane", MATERIAL_PANE),
    ("pane[]", PANE),
    ("medium", MEDIUM),
    ("medium.ARRAY", VOXEL_FILE),
    ("medium.gas", GAS),
    ("medium.gas.ARRAY", VOXEL_FILE),
    ("medium.region[]", REGION),
    ("medium.region[].box", BOUNDS),
    ("medium.region[].mesh", MESH),
    ("medium.region[].density", DENSITY_FILE),
    ("medium.region[].ARRAY", VOXEL_FILE),
    ("medium.region[].gas", GAS),
    ("medium.region[].gas.ARRAY", VOXEL_FILE),
    ("light[] (sun)", SUN),
    ("light[] (sky)", SKY),
    ("light[] (cie-sky)", CIE_SKY),
    ("light[] (perez-sky)", PEREZ_SKY),
    ("light[] (image-sky)", IMAGE_SKY),
    ("light[] (emitter)", EMITTER),
    ("light[] (planet)", PLANET),
    ("light[] (point)", POINT),
    ("light[] (spot)", SPOT),
    ("light[] (tube)", TUBE),
    ("light[] (luminaire)", LUMINAIRE),
    ("SPECTRUM", SPECTRUM),
    ("camera[]", CAMERA),
];

/// A key of the scene format, for manuals and editors.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneKey {
    /// Dotted path; `[]` marks the entries of a list, capitals stand for a free name.
    pub path: String,
    /// Type of the value.
    pub value: &'static str,
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
        value: k.value,
        unit: k.unit,
        default: k.default,
        description: k.description,
    })
    .collect()
}
