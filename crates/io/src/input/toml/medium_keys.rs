//! The keys of media: panes, the medium and its regions, arrays from files, gases.

use super::band_kinds::{BANDS, COEFFICIENT, FLUX, SHARE_OF_BANDS};
use super::keys::keys;
use super::kinds::{
    BOOLEAN, EDGE, FILE, KELVIN, LENGTH, NET_POWER, NON_NEGATIVE, POINT, POINTS, ROTATIONS, TABLE, TABLES,
    TEXT, UP_TO_ONE, shown, words,
};
use super::surface_keys::Bounds;
use zonal_math::Vec3;
use zonal_scene::Bands;

keys! {
    /// Optical properties of a volume in the band of sunlight.
    SOLAR_OPTICS: SolarOptics = [SolarOptics] {
        solar_extinction: f64 = NON_NEGATIVE.in_unit("1/m"), "the extinction", "extinction of sunlight (thermal mode with lights)";
        solar_albedo: f64 = UP_TO_ONE, "the albedo", "albedo of sunlight (thermal mode with lights)";
    }
    /// `[[pane]]`.
    PANE: Pane = [Pane, SolarOptics] {
        name: String = TEXT, "pane1, …", "name";
        polygon: Vec<Vec3> = POINTS, "required", "corners in order; plane and convex", "[[x, y, z], [x, y, z], [x, y, z]]";
        thickness: f64 = LENGTH, "required", "thickness", "0.01 (metres)";
        extinction: Bands = COEFFICIENT, "required", "extinction coefficient",
            "[red, green, blue] (1/m; the transmittance is exp(-extinction × thickness))";
        albedo: Bands = SHARE_OF_BANDS, "0", "scattering albedo";
        emission: Bands = FLUX.in_unit("W/m2"), "0", "black emissive power (light mode)";
        absorption: Bands = COEFFICIENT, "", "extinction × (1 - albedo), in place of one of them";
        temperature: f64 = KELVIN, "", "given temperature (thermal mode)";
        heat_source: f64 = NET_POWER.in_unit("W/m3").described("0"), "0", "radiative equilibrium (thermal mode)";
    }
    /// `materials.NAME.pane`.
    MATERIAL_PANE: MaterialPane = [MaterialPane, SolarOptics] {
        thickness: f64 = LENGTH, "the file's", "thickness";
        extinction: Bands = COEFFICIENT, "the file's", "extinction coefficient";
        albedo: Bands = SHARE_OF_BANDS, "the file's", "scattering albedo";
        emission: Bands = FLUX.in_unit("W/m2"), "0", "black emissive power (light mode)";
        temperature: f64 = KELVIN, "", "given temperature (thermal mode)";
        heat_source: f64 = NET_POWER.in_unit("W/m3").described("0"), "0", "radiative equilibrium (thermal mode)";
    }
    /// Properties of a medium or region.
    MEDIUM_PROPERTIES: MediumProperties = [MediumProperties, SolarOptics] {
        extinction: Bands = COEFFICIENT, "0 with regions, else required", "extinction coefficient";
        albedo: Bands = SHARE_OF_BANDS.described("bands in [0, 1] | array"), "0", "scattering albedo";
        emission: Bands = BANDS.described("bands from 0 | array").in_unit("W/m2"), "0", "black emissive power (light mode)";
        source: Bands = BANDS.in_unit("W/m3"), "0", "volumetric source (light mode)";
        absorption: Bands = COEFFICIENT, "", "extinction × (1 - albedo), in place of one of them";
        temperature: f64 = KELVIN.described("number above 0 | array"), "", "given temperature (thermal mode)";
        heat_source: f64 = NET_POWER.in_unit("W/m3").described("number | array"), "", "given heat source; 0 is radiative equilibrium (thermal mode)";
        gas: () = TABLE, "", "gas model that gives absorption and band fractions (thermal mode)";
    }
    /// `[medium]`.
    MEDIUM: Medium = [Bounds, Medium, MediumProperties, SolarOptics] {
        cells: () = shown("[integer, integer, integer]", ""), "or cell_size", "voxels along each axis";
        cell_size: () = shown("number | [number, number, number]", "m"), "or cells", "edge of a voxel, rounded to whole voxels";
        region: () = TABLES, "", "parts with other properties, each over those before it";
    }
    /// `[[medium.region]]`.
    REGION: Region = [Region, MediumProperties, SolarOptics] {
        r#box: () = TABLE, "", "box; voxels that it cuts are mixed by volume";
        mesh: () = TABLE, "", "voxels whose centre lies inside a closed mesh";
        density: () = TABLE, "", "extinction from a file";
    }
    /// Placement of an OpenVDB grid.
    VDB: Vdb = [Vdb] {
        grid: String = TEXT, "the only grid, or \"density\"", "grid of an OpenVDB file";
        unit: f64 = LENGTH, "1", "length unit of an OpenVDB file";
        translate: Vec3 = EDGE, "[0, 0, 0]", "translation of an OpenVDB grid";
        rotate_degrees: Vec3 = ROTATIONS, "[0, 0, 0]", "rotations of an OpenVDB grid about x, then y, then z";
        level_set: bool = BOOLEAN, "false", "reads a level set as the density 1 inside its surface";
    }
    /// Arrays of medium properties.
    VOXEL_FILE: VoxelFile = [VoxelFile, Vdb] {
        file: () = FILE, "required", ".npy, .vdb or .vol", "\"smoke.npy\" (or .vdb, .vol)";
        min: Vec3 = POINT, "the file's box", "smallest corner of the box that the array fills";
        max: Vec3 = POINT, "the file's box", "largest corner of the box that the array fills";
        scale: Bands = BANDS.in_unit("that of the quantity"), "1", "factor of the values";
    }
    /// `density`.
    DENSITY_FILE: DensityFile = [VoxelFile, DensityFile, Vdb] {
        interpolation: usize = words!("linear", "constant"), "\"linear\"",
            "field between the values of a density: trilinear, or constant over each element";
    }
    /// `gas` of a medium or region.
    GAS: Gas = [Gas] {
        model: () = shown("name of a gas model", ""), "required", "model: zonal gas --help lists the names", "\"wsgg-bordbar-2020\"";
        h2o: () = shown("number from 0 to 1, or array", ""), "0", "mole fraction of water vapour";
        co2: () = shown("number from 0 to 1, or array", ""), "0", "mole fraction of carbon dioxide";
        soot: () = shown("number from 0 to 1, or array", ""), "0", "volume fraction of soot";
        pressure: () = shown("number above 0, or array", "Pa"), "101325", "total pressure";
    }
}
