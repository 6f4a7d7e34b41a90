//! The keys of surfaces: shapes, properties, meshes and their materials, values from files.

use super::band_kinds::{FLUX_OF_LIGHT, SHARE_OF_BANDS};
use super::keys::keys;
use super::kinds::{
    BOOLEAN, COLUMN, DEGREES, EDGE, FILE, KELVIN, LENGTH, NET_POWER, NON_NEGATIVE, POINT, POINTS, POSITIVE,
    ROTATIONS, TABLE, TEXT, UP_TO_ONE, shown, words,
};
use zonal_math::Vec3;
use zonal_scene::Bands;

keys! {
    /// `[[surface]]`.
    SURFACE: Surface = [Surface, Shapes, SurfaceProperties] {
        name: String = TEXT, "surface1, …", "unique name";
        faces: () = shown("table of faces", ""), "", "properties of single faces x0, x1, y0, y1, z0, z1 of a box or room";
        omit: () = shown("list of faces", ""), "[]", "walls that a room lacks";
        materials: () = shown("table of materials", ""), "", "properties of single materials of a mesh";
        solid: bool = BOOLEAN, "true", "treats closed parts of a mesh as solids and rooms";
        open_sides: usize = words!("file", "both"), "\"file\"",
            "sides of the open parts of a mesh; with \"both\", parts that are turned inside out count as open";
        lights: bool = BOOLEAN, "true", "adds the lights of a glTF mesh to the scene (light mode)";
    }
    /// The shapes of a surface, of which one is given.
    SHAPES: Shapes = [Shapes] {
        rectangle: () = TABLE, "", "parallelogram; the front faces edge1 × edge2";
        triangle: () = TABLE, "", "triangle; its front sees the corners counter-clockwise";
        r#box: () = TABLE, "", "solid box with outward normals";
        room: () = TABLE, "", "six walls with inward normals";
        mesh: () = TABLE, "", "mesh file: OBJ, STL, PLY, GLB, glTF, MSH, VTU or VTP";
    }
    /// Properties of a surface, of a face or of a material.
    SURFACE_PROPERTIES: SurfaceProperties = [SurfaceProperties] {
        reflectance: Bands = SHARE_OF_BANDS, "0.5, or the mesh's", "diffuse reflectance";
        transmittance: Bands = SHARE_OF_BANDS, "0, or the mesh's",
            "diffuse transmittance of a thin sheet, from each side to the other (light mode)";
        emission: Bands = FLUX_OF_LIGHT.in_unit("W/m2").described("bands from 0"), "0, or the mesh's",
            "emitted flux; in thermal mode light of an emitter, a number";
        sides: usize = words!("front", "both"), "\"front\"; of open meshes by their file", "sides that take part in the exchange";
        patch_size: f64 = LENGTH, "that of [solve]", "target edge of a patch";
        texture: () = FILE, "", "PNG or JPEG that multiplies the reflectance (light mode)";
        emissivity: () = shown("bands in [0, 1] | table", ""), "1 - reflectance", "diffuse emissivity, in place of the reflectance";
        solar_absorptance: f64 = UP_TO_ONE, "the emissivity", "absorbed fraction of sunlight (thermal mode with lights)";
        back: () = TABLE, "as the front", "emissivity of the back, with sides = \"both\" (thermal mode)";
        temperature: f64 = KELVIN, "", "given temperature (thermal mode)";
        heat_flux: f64 = NET_POWER.in_unit("W/m2"), "", "given net radiative flux that leaves the surface (thermal mode)";
        net_power: f64 = NET_POWER.in_unit("W"), "", "given net power that leaves the whole surface (thermal mode)";
        node: () = shown("text", ""), "", "name of the [[node]] whose temperature the surface has (thermal mode)";
        heat_transfer_coefficient: f64 = NON_NEGATIVE.in_unit("W/(m2 K)"), "", "convection to air of ambient_temperature (thermal mode)";
        ambient_temperature: f64 = KELVIN, "", "temperature of the air (thermal mode)";
    }
    /// `temperature`, `heat_flux`, `net_power`, `emissivity`, `reflectance` or `emission` of a mesh from a file.
    VALUE_FILE: ValueFile = [ValueFile] {
        file: () = FILE, "required", ".csv, .npy, .vtu or .vtp", "\"values.csv\" (or .npy, .vtu, .vtp)";
        column: String = COLUMN, "the only one, or the one named like the quantity",
            "column of the table by name or number, or array of cell data";
        by: usize = words!("face", "material"), "\"face\"",
            "one row for each face of the mesh file in its order, or rows of a material's name and its value";
    }
    /// `faces`.
    FACES: Faces = [Faces] {
        x0: () = TABLE, "", FACE_TABLE;
        x1: () = TABLE, "", FACE_TABLE;
        y0: () = TABLE, "", FACE_TABLE;
        y1: () = TABLE, "", FACE_TABLE;
        z0: () = TABLE, "", FACE_TABLE;
        z1: () = TABLE, "", FACE_TABLE;
    }
    /// `rectangle`.
    RECTANGLE: Rectangle = [Rectangle] {
        origin: Vec3 = POINT, "required", "corner", "[x, y, z]";
        edge1: Vec3 = EDGE, "required", "first edge from the corner", "[x, y, z]";
        edge2: Vec3 = EDGE, "required", "second edge from the corner", "[x, y, z]";
    }
    /// `triangle`.
    TRIANGLE: Triangle = [Triangle] {
        corners: Vec<Vec3> = POINTS.described("three points"), "required", "corners, counter-clockwise seen from the front",
            "[[x, y, z], [x, y, z], [x, y, z]]";
    }
    /// `room`, and `box` of a region.
    BOUNDS: Bounds = [Bounds] {
        min: Vec3 = POINT, "required", "smallest corner", "[x, y, z]";
        max: Vec3 = POINT, "required", "largest corner", "[x, y, z]";
    }
    /// `box` of a surface.
    BOX: Box = [Bounds, Box] {
        rotate_z_degrees: f64 = DEGREES, "0", "rotation about the vertical through the centre";
    }
    /// Every placed mesh: `mesh` of a region.
    PLACED_MESH: PlacedMesh = [PlacedMesh] {
        file: () = FILE, "required", ".obj, .stl, .ply, .glb, .gltf, .msh, .vtu or .vtp",
            "\"mesh.obj\" (or .stl, .ply, .glb, .gltf, .msh, .vtu, .vtp)";
        scale: f64 = POSITIVE.in_unit("m per unit of the file"), "1", "factor of lengths";
        translate: Vec3 = EDGE, "[0, 0, 0]", "translation after scale and rotation";
        rotate_degrees: Vec3 = ROTATIONS, "[0, 0, 0]", "rotations about x, then y, then z";
    }
    /// `mesh` of a surface.
    SURFACE_MESH: SurfaceMesh = [PlacedMesh, SurfaceMesh] {
        normals: usize = words!("file", "flat"), "\"file\"",
            "shading of pictures: by the vertex normals and normal maps of the file, or of flat faces; solves see flat faces";
    }
    /// `materials.NAME`.
    MATERIAL: Material = [Material, SurfaceProperties] {
        pane: () = shown("table | boolean", ""), "as the file says", "makes the material a pane, or with false an opaque surface";
        omit: bool = BOOLEAN, "false", "leaves the material out";
        region: bool = BOOLEAN, "false", "fills the medium inside the closed material with its extinction";
    }
}
const FACE_TABLE: &str = "properties as of a surface";
