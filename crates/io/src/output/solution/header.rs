//! The JSON document inside a solution file: all that is not an array over zones, facets or cells. The fields are described once, for
//! writing and reading (serde).

use super::network::NetworkFormat;
use crate::output::report::codec::{
    bands, engine, join_blocks, light_grouping, list_of, nan_bands, patch_rule, polynomials, printable_text,
    vector, zone_basis,
};
use crate::output::report::notes::diagnostics;
use crate::output::report::{block_json, encode_bands};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use zonal_math::Vec3;
use zonal_scene::{
    Band, BandFractions, BandSet, Bands, Camera, CellFractions, Diagnostic, EmissivityTable, Engine,
    FaceMesh, IntensityDistribution, Lens, Light, LightGrouping, Pane, PatchRule, Plate, Scene,
    SideEmissivity, Sides, SkyDistribution, Solution, SolveOptions, Surface, SurfaceEmissivity, Surroundings,
    Thermal, ThermalCondition, Transmission, ZoneBasis,
};

/// The version of the format.
pub(super) const FORMAT_VERSION: u64 = 7;
/// The name of the format.
pub(super) const FORMAT: &str = "zonal solution";

const HOW_TO_READ: &str =
    "import json, numpy as np; z = np.load(file); header = json.loads(bytes(z['header.json']))";

/// The part of a scene that the header holds.
#[derive(Serialize, Deserialize)]
pub(super) struct SceneHeader {
    #[serde(deserialize_with = "printable_text")]
    pub(super) name: String,
    #[serde(with = "diagnostics")]
    pub(super) notes: Vec<Diagnostic>,
    #[serde(with = "surfaces")]
    pub(super) surfaces: Vec<Surface>,
    /// Mesh files with their numbers of faces.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "meshes")]
    pub(super) meshes: Vec<FaceMesh>,
    #[serde(with = "panes")]
    pub(super) panes: Vec<Pane>,
    /// Number of textures.
    pub(super) textures: usize,
    #[serde(rename = "voxmap")]
    pub(super) voxel_grid: Option<VoxelGridHeader>,
    #[serde(with = "lights")]
    pub(super) lights: Vec<Light>,
    #[serde(with = "SurroundingsFormat")]
    pub(super) surroundings: Surroundings,
    #[serde(default)]
    pub(super) periodic: [bool; 3],
    #[serde(default)]
    pub(super) symmetry_planes: [[bool; 2]; 3],
    /// Lower and upper corner of the boundary box, m.
    #[serde(default)]
    pub(super) boundary_box: Option<[[f64; 3]; 2]>,
    pub(super) thermal: Option<ThermalFormat>,
    #[serde(with = "cameras")]
    pub(super) cameras: Vec<Camera>,
    #[serde(with = "OptionsFormat")]
    pub(super) options: SolveOptions,
}

/// Corner, cell and size of a voxel grid.
#[derive(Serialize, Deserialize)]
pub(super) struct VoxelGridHeader {
    #[serde(with = "vector")]
    pub(super) min: Vec3,
    #[serde(with = "vector")]
    pub(super) cell: Vec3,
    pub(super) dims: [usize; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Surface")]
struct SurfaceFormat {
    name: String,
    #[serde(with = "bands")]
    reflectance: Bands,
    #[serde(with = "bands")]
    emission: Bands,
    reflectance_texture: Option<usize>,
    emission_texture: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none", with = "transmission")]
    transmission: Option<Transmission>,
    #[serde(with = "SidesFormat")]
    sides: Sides,
    patch_size: Option<f64>,
    solid: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Transmission")]
struct TransmissionFormat {
    #[serde(with = "bands")]
    transmittance: Bands,
    texture: Option<usize>,
}

/// An optional transmission.
mod transmission {
    use super::TransmissionFormat;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use zonal_scene::Transmission;

    #[derive(Serialize, Deserialize)]
    struct Wrapper(#[serde(with = "TransmissionFormat")] Transmission);

    pub(super) fn serialize<S: Serializer>(t: &Option<Transmission>, s: S) -> Result<S::Ok, S::Error> {
        t.map(Wrapper).serialize(s)
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Transmission>, D::Error> {
        Ok(Option::<Wrapper>::deserialize(d)?.map(|w| w.0))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FaceMesh")]
struct FaceMeshFormat {
    name: String,
    faces: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Sides", rename_all = "lowercase")]
enum SidesFormat {
    Front,
    Both,
}

/// A pane without its plates.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Pane")]
struct PaneFormat {
    name: String,
    #[serde(skip)]
    plates: Vec<Plate>,
    thickness: f64,
    #[serde(with = "bands")]
    extinction: Bands,
    #[serde(with = "bands")]
    albedo: Bands,
    #[serde(with = "bands")]
    emission: Bands,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Light", tag = "kind", rename_all = "lowercase")]
enum LightFormat {
    Sun {
        name: String,
        #[serde(with = "vector")]
        direction: Vec3,
        #[serde(with = "bands")]
        irradiance: Bands,
        angular_diameter: f64,
    },
    Sky {
        name: String,
        #[serde(with = "bands")]
        radiance: Bands,
        #[serde(with = "sky_distribution", default, skip_serializing_if = "SkyDistribution::is_uniform")]
        distribution: SkyDistribution,
    },
    Point {
        name: String,
        #[serde(with = "vector")]
        position: Vec3,
        #[serde(with = "bands")]
        intensity: Bands,
        #[serde(with = "distribution")]
        distribution: IntensityDistribution,
    },
    Emitter {
        name: Option<String>,
        surface: usize,
    },
}

/// A distribution of intensity as the numbers that determine it.
mod distribution {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use zonal_scene::IntensityDistribution;

    pub(super) fn serialize<S: Serializer>(d: &IntensityDistribution, s: S) -> Result<S::Ok, S::Error> {
        d.defining_numbers().serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<IntensityDistribution, D::Error> {
        let numbers = Vec::<f64>::deserialize(d)?;
        IntensityDistribution::from_defining_numbers(&numbers)
            .ok_or_else(|| serde::de::Error::custom("the distribution of intensity is none"))
    }
}

/// A distribution of radiance as the numbers that determine it; the pixels of a picture are an array of the file.
mod sky_distribution {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use zonal_scene::SkyDistribution;

    pub(super) fn serialize<S: Serializer>(d: &SkyDistribution, s: S) -> Result<S::Ok, S::Error> {
        d.numbers().serialize(s)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<SkyDistribution, D::Error> {
        let numbers = Vec::<f64>::deserialize(d)?;
        SkyDistribution::from_numbers(&numbers)
            .ok_or_else(|| serde::de::Error::custom("the distribution of radiance is none"))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Surroundings")]
struct SurroundingsFormat {
    name: Option<String>,
    #[serde(with = "bands")]
    radiance: Bands,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Camera")]
struct CameraFormat {
    name: String,
    #[serde(with = "vector")]
    origin: Vec3,
    #[serde(with = "vector")]
    target: Vec3,
    #[serde(with = "vector")]
    up: Vec3,
    fov: f64,
    #[serde(flatten, with = "LensFormat")]
    lens: Lens,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Lens")]
struct LensFormat {
    #[serde(default)]
    aperture: f64,
    focus: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SolveOptions")]
struct OptionsFormat {
    tolerance: f64,
    patch_size: Option<f64>,
    #[serde(with = "patch_rule")]
    patch_rule: PatchRule,
    restore_closure: Option<bool>,
    max_iterations: usize,
    residual: f64,
    scattering_orders: Option<usize>,
    #[serde(with = "engine")]
    engine: Engine,
    #[serde(rename = "light_groups", with = "light_grouping")]
    light_grouping: LightGrouping,
    #[serde(with = "zone_basis")]
    zone_basis: ZoneBasis,
    discretization_error: Option<bool>,
}

/// Thermal mode: band fractions (null for grey) and boundary conditions.
#[derive(Serialize, Deserialize)]
pub(super) struct ThermalFormat {
    band_fractions: Option<FractionsFormat>,
    #[serde(with = "conditions")]
    surfaces: Vec<ThermalCondition>,
    #[serde(with = "conditions")]
    panes: Vec<ThermalCondition>,
    surroundings: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    network: Option<NetworkFormat>,
    /// Emissivities of surfaces by temperature or side; empty if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    emissivities: Vec<EmissivityFormat>,
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

/// `{temperature: K}`, `{heat: W/m² or W/m³}` or `{net_power: W}`.
#[derive(Serialize, Deserialize)]
#[serde(remote = "ThermalCondition")]
enum ConditionFormat {
    #[serde(rename = "temperature")]
    Temperature(f64),
    #[serde(rename = "heat")]
    Flux(f64),
    #[serde(rename = "net_power")]
    Power(f64),
}

list_of!(surfaces, Surface, "SurfaceFormat");
list_of!(meshes, FaceMesh, "FaceMeshFormat");
list_of!(panes, Pane, "PaneFormat");
list_of!(lights, Light, "LightFormat");
list_of!(cameras, Camera, "CameraFormat");
list_of!(conditions, ThermalCondition, "ConditionFormat");

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
            network: network.as_ref().map(NetworkFormat::new),
            emissivities: emissivities.iter().filter(|_| varied).map(EmissivityFormat::new).collect(),
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
        let emissivities: Vec<SurfaceEmissivity> =
            emissivities.into_iter().map(EmissivityFormat::into_emissivity).collect::<Result<_, _>>()?;
        let (band_fractions, cell_fractions) = match band_fractions {
            None => (BandFractions::Grey, None),
            Some(f) if f.black_body => {
                (BandFractions::of_wavelengths(bands, block).unwrap_or_default(), None)
            }
            Some(f) => f.of_block(bands, block, cells)?,
        };
        let network = network.map(NetworkFormat::into_network);
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

/// Emissivities of a surface by temperature or side.
#[derive(Serialize, Deserialize)]
struct EmissivityFormat {
    table: Option<Vec<[f64; 2]>>,
    back: Option<SideFormat>,
}

/// The back of a surface.
#[derive(Serialize, Deserialize)]
struct SideFormat {
    #[serde(with = "nan_bands")]
    reflectance: Bands,
    table: Option<Vec<[f64; 2]>>,
}

impl EmissivityFormat {
    fn new(e: &SurfaceEmissivity) -> EmissivityFormat {
        let points = |t: &EmissivityTable| t.points().to_vec();
        let SurfaceEmissivity { table, back } = e;
        let side = |SideEmissivity { reflectance, table }: &SideEmissivity| SideFormat {
            reflectance: *reflectance,
            table: table.as_ref().map(points),
        };
        EmissivityFormat { table: table.as_ref().map(points), back: back.as_ref().map(side) }
    }

    fn into_emissivity(self) -> Result<SurfaceEmissivity, String> {
        let table = |points: Option<Vec<[f64; 2]>>| {
            let table = points.map(|p| EmissivityTable::new(&p)).transpose();
            table.map_err(|e| format!("thermal.emissivities: {e}"))
        };
        let side = |s: SideFormat| {
            Ok::<_, String>(SideEmissivity { reflectance: s.reflectance, table: table(s.table)? })
        };
        let back = self.back.map(side).transpose()?;
        Ok(SurfaceEmissivity { table: table(self.table)?, back })
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
        header.lights.iter_mut().for_each(|l| match l {
            Light::Sun { name, .. } | Light::Sky { name, .. } | Light::Point { name, .. } => name.clear(),
            Light::Emitter { name, .. } => *name = None,
        });
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
