//! The JSON document inside a solution file: all that is not an array over zones, facets or cells. The fields are described once, for
//! writing and reading (serde).

use crate::output::report::codec::{join_blocks, polynomials};
use crate::output::report::{block_json, encode_bands};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use zonal_math::Vec3;
use zonal_scene::{
    Band, BandFractions, BandSet, Camera, CellFractions, Diagnostic, FaceMesh, Light, Pane, Scene, Solution,
    SolveOptions, Surface, SurfaceEmissivity, Surroundings, Thermal, ThermalCondition, ThermalNetwork,
    printable_text,
};

/// The version of the format.
pub(super) const FORMAT_VERSION: u64 = 8;
/// The name of the format.
pub(super) const FORMAT: &str = "zonal solution";

const HOW_TO_READ: &str =
    "import json, numpy as np; z = np.load(file); header = json.loads(bytes(z['header.json']))";

/// The part of a scene that the header holds.
#[derive(Serialize, Deserialize)]
pub(super) struct SceneHeader {
    #[serde(deserialize_with = "printable_text")]
    pub(super) name: String,
    pub(super) notes: Vec<Diagnostic>,
    pub(super) surfaces: Vec<Surface>,
    /// Mesh files with their numbers of faces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) meshes: Vec<FaceMesh>,
    pub(super) panes: Vec<Pane>,
    /// Number of textures.
    pub(super) textures: usize,
    #[serde(rename = "voxmap")]
    pub(super) voxel_grid: Option<VoxelGridHeader>,
    pub(super) lights: Vec<Light>,
    pub(super) surroundings: Surroundings,
    #[serde(default)]
    pub(super) periodic: [bool; 3],
    #[serde(default)]
    pub(super) symmetry_planes: [[bool; 2]; 3],
    /// Lower and upper corner of the boundary box, m.
    #[serde(default)]
    pub(super) boundary_box: Option<[[f64; 3]; 2]>,
    pub(super) thermal: Option<ThermalFormat>,
    pub(super) cameras: Vec<Camera>,
    pub(super) options: SolveOptions,
}

/// Corner, cell and size of a voxel grid.
#[derive(Serialize, Deserialize)]
pub(super) struct VoxelGridHeader {
    pub(super) min: Vec3,
    pub(super) cell: Vec3,
    pub(super) dims: [usize; 3],
}

/// Thermal mode: band fractions (null for grey) and boundary conditions.
#[derive(Serialize, Deserialize)]
pub(super) struct ThermalFormat {
    band_fractions: Option<FractionsFormat>,
    surfaces: Vec<ThermalCondition>,
    panes: Vec<ThermalCondition>,
    surroundings: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    network: Option<ThermalNetwork>,
    /// Emissivities of surfaces by temperature or side; empty if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    emissivities: Vec<SurfaceEmissivity>,
}

#[derive(Serialize, Deserialize)]
struct FractionsFormat {
    /// Those of all bands in a file; of one block while it is written.
    #[serde(with = "polynomials")]
    coefficients: Vec<Vec<f64>>,
    range: [f64; 2],
    #[serde(default)]
    allow_partial: bool,
    /// True if negative values of the polynomials count as 0, and the others are divided by their sum.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    normalized: bool,
    /// True if the fractions are those of the black body between the wavelengths of the bands, without coefficients.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    black_body: bool,
}

/// Band fractions that differ from cell to cell, as a file holds them.
pub(super) struct CellPolynomials {
    /// The kind of each cell.
    pub(super) kind_of_cell: Vec<u32>,
    /// Coefficients of the polynomial of every band, for each kind.
    pub(super) kinds: Vec<Vec<Vec<f64>>>,
}

impl ThermalFormat {
    fn new(t: &Thermal) -> ThermalFormat {
        // The fractions of cells are arrays.
        let Thermal {
            band_fractions,
            cell_fractions: _,
            surfaces,
            panes,
            surroundings,
            network,
            emissivities,
        } = t;
        let band_fractions = match band_fractions {
            BandFractions::Grey => None,
            BandFractions::BlackBody { .. } => Some(FractionsFormat {
                coefficients: vec![Vec::new(); Band::count()],
                range: [1.0, 1.0],
                allow_partial: false,
                normalized: false,
                black_body: true,
            }),
            BandFractions::GreyGases { coefficients, range, allow_partial, all_bands } => {
                Some(FractionsFormat {
                    black_body: false,
                    coefficients: coefficients.clone().into_rgb().to_vec(),
                    range: *range,
                    allow_partial: *allow_partial,
                    normalized: all_bands.is_some(),
                })
            }
        };
        let varied = t.has_varied_emissivities();
        ThermalFormat {
            band_fractions,
            surfaces: surfaces.clone(),
            panes: panes.clone(),
            surroundings: *surroundings,
            network: network.clone(),
            emissivities: if varied { emissivities.clone() } else { Vec::new() },
        }
    }

    /// The thermal data of one block of bands; `cells` gives the kind of each cell and the polynomials of every kind and band, if they differ.
    pub(super) fn into_thermal(
        self,
        bands: &BandSet,
        block: usize,
        cells: Option<CellPolynomials>,
    ) -> Result<Thermal, String> {
        let ThermalFormat { band_fractions, surfaces, panes, surroundings, network, emissivities } = self;
        let (band_fractions, cell_fractions) = match band_fractions {
            None => (BandFractions::Grey, None),
            Some(f) if f.black_body => {
                (BandFractions::of_wavelengths(bands, block).unwrap_or_default(), None)
            }
            Some(f) => f.of_block(bands, block, cells)?,
        };
        Ok(Thermal { band_fractions, cell_fractions, surfaces, panes, surroundings, network, emissivities })
    }
}

impl FractionsFormat {
    /// The fractions of one block of bands: of the scene, and of its cells if they differ.
    fn of_block(
        self,
        bands: &BandSet,
        block: usize,
        cells: Option<CellPolynomials>,
    ) -> Result<(BandFractions, Option<CellFractions>), String> {
        let FractionsFormat { coefficients, range, allow_partial, normalized, black_body: _ } = self;
        let count = bands.count();
        let lists = cells.iter().flat_map(|c| &c.kinds).chain(std::iter::once(&coefficients));
        if let Some(list) = lists.into_iter().find(|list| list.len() != count) {
            return Err(format!("thermal.band_fractions: there are {} for {count} bands", list.len()));
        }
        let of = |polynomials: &[Vec<f64>]| BandFractions::of_polynomials(bands, block, polynomials, range);
        let mut of_scene = of(&coefficients);
        if let BandFractions::GreyGases { allow_partial: partial, all_bands, .. } = &mut of_scene {
            *partial = allow_partial;
            if !normalized {
                *all_bands = None;
            }
        }
        let cell_fractions = cells.map(|cells| CellFractions {
            kinds: cells.kinds.iter().map(|k| of(k)).collect(),
            kind_of_cell: cells.kind_of_cell,
        });
        Ok((of_scene, cell_fractions))
    }
}

impl SceneHeader {
    fn new(scene: &Scene) -> SceneHeader {
        SceneHeader {
            name: scene.name().to_string(),
            notes: scene.notes().to_vec(),
            surfaces: scene.surfaces().to_vec(),
            meshes: scene.faces().meshes.clone(),
            panes: scene.panes().to_vec(),
            textures: scene.textures().len(),
            voxel_grid: scene.voxel_grid().map(|v| VoxelGridHeader {
                min: v.min(),
                cell: v.cell(),
                dims: v.dims(),
            }),
            lights: scene.lights().to_vec(),
            surroundings: scene.surroundings().clone(),
            periodic: scene.periodic(),
            symmetry_planes: scene.symmetry_planes(),
            boundary_box: scene
                .boundary_box()
                .filter(|_| scene.voxel_grid().is_none())
                .map(|(min, max)| [min.array(), max.array()]),
            thermal: scene.thermal().map(ThermalFormat::new),
            cameras: scene.cameras().to_vec(),
            options: scene.options().clone(),
        }
    }
}

/// The header of a scene without names, notes and cameras, on which no solution depends.
pub(in crate::output) fn encode_unnamed_scene(scene: &Scene) -> Value {
    let of_block = |scene: Scene| {
        let mut header = SceneHeader::new(&scene);
        (header.name, header.notes, header.cameras) = Default::default();
        header.surfaces.iter_mut().for_each(|s| s.name = String::new());
        header.meshes.iter_mut().for_each(|m| m.name = String::new());
        header.panes.iter_mut().for_each(|p| p.name = String::new());
        header.lights.iter_mut().for_each(Light::clear_name);
        header.surroundings.name = None;
        // As in `encode_header`.
        serde_json::to_value(header).unwrap_or_default()
    };
    let (mut v, _) = join_blocks(scene.bands(), scene.blocks().map(of_block).collect());
    v["bands"] = encode_bands(scene.bands());
    v
}

/// The header of a solution: its scene and its report.
pub(super) fn encode_header(s: &Solution) -> Value {
    let of_block = |s: &Solution| {
        // Serialisation into a JSON value fails only for maps with keys that are no texts; there are none.
        let mut v = serde_json::to_value(SceneHeader::new(&s.scene)).unwrap_or_default();
        let mut report = block_json(s);
        v["provenance"] = report["provenance"].take();
        v["report"] = report;
        v
    };
    let scene = &s.scene;
    let (mut v, band_lists) = join_blocks(scene.bands(), s.blocks().map(of_block).collect());
    v["band_lists"] = band_lists.into_iter().collect();
    if !scene.bands().is_rgb() {
        v["bands"] = encode_bands(scene.bands());
    }
    v["format"] = FORMAT.into();
    v["format_version"] = FORMAT_VERSION.into();
    v["how_to_read"] = HOW_TO_READ.into();
    v["units"] = json!({
        "lengths": "m", "extinction": "1/m", "radiosity, incident, direct, error, direct_error, group_*": "W/m² per band",
        "temperature, temperature_error": "K", "net, net_error": "W/m² of patches, W/m³ of voxels and panes",
        "source": "W/m³ per band", "radiance": "W/(m² sr) per band", "angles": "rad, fov in degrees",
    });
    v["order_of_fields"] = "patches, then voxel zones, then pane zones".into();
    v["mode"] = if scene.thermal().is_some() { "thermal" } else { "light" }.into();
    v
}

/// Hash of the scene and version of the program.
#[derive(Deserialize)]
pub(super) struct Provenance {
    #[serde(deserialize_with = "printable_text")]
    pub(super) scene_hash: String,
    #[serde(deserialize_with = "printable_text")]
    pub(super) version: String,
}
