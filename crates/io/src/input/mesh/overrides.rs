//! `materials."X"`: what a scene says about the materials of a mesh.

use super::Mesh;
use crate::input::build::Builder;
use crate::input::error::InputError;
use crate::input::node::{Table, suggestion};
use crate::input::surface::{LOOK, Look};
use crate::input::thermal;
use std::collections::BTreeMap;
use zonal_scene::{Bands, Known};

/// What `materials."X"` says.
#[derive(Clone, Default)]
pub(crate) struct Override {
    pub(crate) look: Look,
    pub(crate) omit: bool,
    pub(crate) region: bool,
    /// None: as the file says; Some(None): opaque.
    pub(crate) pane: Option<Option<PaneKeys>>,
    pub(crate) offset: Option<usize>,
    /// What holds of surfaces alone.
    pub(crate) wall: Option<Wall>,
}

/// The first key of a look, in the order of the file, among those of a material.
#[derive(Clone)]
pub(crate) struct Wall {
    pub(crate) offset: usize,
    /// The whole key.
    pub(crate) key: String,
    /// Its last part.
    pub(crate) name: &'static str,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct PaneKeys {
    pub(crate) thickness: Option<f64>,
    pub(crate) extinction: Option<Bands>,
    pub(crate) albedo: Option<Bands>,
    pub(crate) emission: Option<Bands>,
    /// In thermal mode.
    pub(crate) heat: Option<Known>,
}

pub(crate) fn read(
    table: &Table<'_>,
    mesh: &Mesh,
    b: &mut Builder<'_>,
) -> Result<BTreeMap<usize, Override>, InputError> {
    let mut out = BTreeMap::new();
    let Some(node) = table.get("materials") else {
        return Ok(out);
    };
    for (name, node) in node.any_table()?.entries() {
        let Some(index) = mesh.materials.iter().position(|m| m.name == name) else {
            let names: Vec<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
            let hint = suggestion(name, &names[..names.len().min(40)]);
            return Err(node.error(format!("the mesh has no material '{name}'; {hint}")));
        };
        let mut known = vec!["pane", "omit", "region"];
        known.extend(LOOK);
        let t = node.table(&known)?;
        let pane = t.read("pane", |n| {
            if !n.is_table() {
                return match n.boolean()? {
                    false => Ok(None),
                    true => Ok(Some(PaneKeys::default())),
                };
            }
            let t =
                n.table(&["thickness", "extinction", "albedo", "emission", "temperature", "heat_source"])?;
            thermal::check_mode(&t, b.thermal())?;
            Ok(Some(PaneKeys {
                heat: thermal::volume(&t)?,
                thickness: t.read("thickness", |n| n.positive())?,
                extinction: t.read("extinction", |n| n.bands(f64::INFINITY))?,
                albedo: t.read("albedo", |n| n.bands(1.0))?,
                emission: t.read("emission", |n| n.bands(f64::INFINITY))?,
            }))
        })?;
        let over = Override {
            look: Look::read(&t, b)?,
            omit: t.read("omit", |n| n.boolean())?.unwrap_or(false),
            region: t.read("region", |n| n.boolean())?.unwrap_or(false),
            pane,
            offset: Some(node.offset()),
            wall: LOOK
                .iter()
                .filter_map(|&name| {
                    let n = t.get(name)?;
                    Some(Wall { offset: n.offset(), key: n.key.clone(), name })
                })
                .min_by_key(|w| w.offset),
        };
        if let (true, Some(None), Some(n)) = (over.region, over.pane, t.get("pane")) {
            return Err(n.error("region = true fills the medium with a glass, and this makes it an opaque surface; keep one of them"));
        }
        out.insert(index, over);
    }
    Ok(out)
}
