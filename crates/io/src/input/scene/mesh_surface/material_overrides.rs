//! `materials."X"`: properties that a scene gives to the materials of a mesh.

use crate::input::mesh::model::MeshData;
use crate::input::reading::error::InputError;
use crate::input::reading::suggestion::suggest;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::surface_keys::read_properties;
use crate::input::scene::thermal;
use crate::input::toml::medium_keys::{MATERIAL_PANE, MaterialPane};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{MATERIAL, Material, SURFACE, SurfaceProperties as PropertyKeys};
use std::collections::BTreeMap;
use zonal_scene::{Bands, ThermalCondition};

/// Materials that an error lists.
const MAX_LISTED_MATERIALS: usize = 40;

/// The override of one material.
#[derive(Clone, Default)]
pub(crate) struct MaterialOverride {
    pub(crate) properties: SurfaceProperties,
    pub(crate) omit: bool,
    pub(crate) region: bool,
    /// None: as the file says; Some(None): opaque.
    pub(crate) pane: Option<Option<PaneOverride>>,
    /// Byte offset of the override in the scene.
    pub(crate) offset: Option<usize>,
    /// The first key in the file that only surfaces have.
    pub(crate) surface_key: Option<SurfaceOnlyKey>,
}

/// A key of surfaces that glass does not have.
#[derive(Clone)]
pub(crate) struct SurfaceOnlyKey {
    pub(crate) offset: usize,
    /// Dotted path.
    pub(crate) path: String,
    /// Last part of the path.
    pub(crate) name: &'static str,
}

/// `pane = { … }` of a material.
#[derive(Clone, Copy, Default)]
pub(crate) struct PaneOverride {
    pub(crate) thickness: Option<f64>,
    pub(crate) extinction: Option<Bands>,
    pub(crate) albedo: Option<Bands>,
    pub(crate) emission: Option<Bands>,
    /// In thermal mode.
    pub(crate) condition: Option<ThermalCondition>,
}

/// The overrides of a surface's table, by the index of their material.
pub(crate) fn read_overrides(
    table: &TomlTable<'_>,
    mesh: &MeshData,
    reader: &mut SceneReader<'_>,
) -> Result<BTreeMap<usize, MaterialOverride>, InputError> {
    let mut out = BTreeMap::new();
    let Some(node) = table.get(&SURFACE.materials) else {
        return Ok(out);
    };
    for (name, node) in node.any_table()?.entries() {
        let Some(index) = mesh.materials.iter().position(|m| m.name == name) else {
            let names: Vec<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
            let hint = suggest(name, &names[..names.len().min(MAX_LISTED_MATERIALS)]);
            return Err(node.error(format!("the mesh has no material '{name}'; {hint}")));
        };
        out.insert(index, read_override(&node, reader)?);
    }
    Ok(out)
}

fn read_override(node: &TomlNode<'_>, reader: &mut SceneReader<'_>) -> Result<MaterialOverride, InputError> {
    let t = node.table(Material::TABLE)?;
    let pane = t.get(&MATERIAL.pane).map(|n| read_pane_override(&n, reader)).transpose()?;
    let surface_keys = PropertyKeys::ALL.iter().filter_map(|k| {
        let n = t.get(k.name)?;
        Some(SurfaceOnlyKey { offset: n.offset(), path: n.key.clone(), name: k.name })
    });
    let over = MaterialOverride {
        surface_key: surface_keys.min_by_key(|k| k.offset),
        properties: read_properties(&t, reader)?,
        omit: t.or_default(&MATERIAL.omit)?,
        region: t.or_default(&MATERIAL.region)?,
        pane,
        offset: Some(node.offset()),
    };
    if let (true, Some(None), Some(n)) = (over.region, over.pane, t.get(&MATERIAL.pane)) {
        return Err(n.error("region = true fills the medium with a glass, and this makes it an opaque surface; keep one of them"));
    }
    Ok(over)
}

/// `pane = true | false | { … }`: none for an opaque surface.
fn read_pane_override(
    n: &TomlNode<'_>,
    reader: &SceneReader<'_>,
) -> Result<Option<PaneOverride>, InputError> {
    if !n.is_table() {
        return Ok(if n.boolean()? { Some(PaneOverride::default()) } else { None });
    }
    let t = n.table(MaterialPane::TABLE)?;
    thermal::check_mode(&t, reader.mode())?;
    let [extinction, albedo] = thermal::read_extinction_and_albedo(&t)?;
    Ok(Some(PaneOverride {
        condition: thermal::read_volume_condition(&t)?,
        thickness: t.value(&MATERIAL_PANE.thickness)?,
        extinction,
        albedo,
        emission: t.value(&MATERIAL_PANE.emission)?,
    }))
}
