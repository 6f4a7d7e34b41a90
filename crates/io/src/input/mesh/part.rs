//! One material of a mesh as surfaces, panes or a region of the medium.

use super::closed::{Shell, check_closed, shells};
use super::overrides::{Override, PaneKeys};
use super::{Face, Loss, Material, Picture};
use crate::input::build::{Builder, Fill};
use crate::input::error::InputError;
use crate::input::medium::Matter;
use crate::input::node::{Node, Table};
use crate::input::surface::{Look, REFLECTANCE};
use std::collections::BTreeMap;
use zonal_scene::{Bands, Facet, Note, Pane, Plate, Sides, Surface, bands};

/// One material of a mesh on its way into the scene.
pub(crate) struct Part<'a, 'n> {
    pub(crate) table: &'a Table<'n>,
    pub(crate) node: &'a Node<'n>,
    pub(crate) name: String,
    pub(crate) material: &'a Material,
    pub(crate) over: &'a Override,
    /// The factor from the file's unit to metres.
    pub(crate) scale: f64,
}

impl Part<'_, '_> {
    fn error(&self, what: impl Into<String>) -> InputError {
        let offset = self.over.offset.unwrap_or(self.node.offset());
        self.table.source.error(offset, &self.table.key, what)
    }

    /// Refuses what is said of surfaces alone: glass has no use for it.
    pub(crate) fn check_glass(&self, thermal: bool) -> Result<(), InputError> {
        let Some(wall) = &self.over.wall else { return Ok(()) };
        let (name, kind) =
            (&self.material.name, if self.over.region { "fills the medium" } else { "is a pane" });
        let known = match wall.name {
            "emission" => "emission",
            _ if self.over.region => "temperature or heat_source",
            _ => "temperature",
        };
        let inside = format!("put {known} into materials.\"{name}\".pane = {{ … }}");
        let opaque = match self.over.region {
            true => String::new(),
            false => format!(", or write materials.\"{name}\".pane = false for an opaque surface"),
        };
        let (why, mend) = match wall.name {
            "emissivity" if thermal => ("has no emissivity", format!("remove this key, and {inside}")),
            "emission" | "temperature" | "heat_flux" | "net_power" => ("this key is of surfaces", inside),
            _ => ("this key is of surfaces", format!("remove it{opaque}")),
        };
        let what = format!("material '{name}' {kind}, and {why}; {mend}");
        Err(self.table.source.error(wall.offset, &wall.key, what))
    }

    /// The picture's index, where there is one.
    fn picture(&self, picture: &Option<Picture>, b: &mut Builder<'_>) -> Result<Option<usize>, InputError> {
        let read = picture.as_ref().map(|p| b.picture(p));
        read.transpose().map_err(|f| self.error(f.to_string()))
    }

    /// One surface a kind of shell: open, body, room.
    pub(crate) fn surfaces(
        &self,
        faces: Vec<(&Face, Shell)>,
        look: Look,
        b: &mut Builder<'_>,
    ) -> Result<(), InputError> {
        let m = self.material;
        let look = self.over.look.or(look);
        m.lost_opaque.iter().for_each(|text| b.note(Note::warning("alpha", text)));
        if look.reflectance.is_none() && m.reflectance.is_none() {
            m.unknown.iter().for_each(|text| b.note(Note::warning("default-material", text)));
        }
        // A reflectance or picture of the scene file replaces the material's picture.
        // What a picture shows is not what is warm.
        let own_picture = look.reflectance.is_none() && look.texture.is_none() && !b.thermal();
        let texture = match own_picture {
            true => self.picture(&m.texture, b)?,
            false => look.texture,
        };
        let emission_texture = match look.emission {
            None if !b.thermal() => self.picture(&m.emission_texture, b)?,
            _ => None,
        };
        let emission = if b.thermal() { [0.0; 3] } else { look.emission.unwrap_or(m.emission) };
        let kinds = [(Shell::Open, ""), (Shell::Body, " (solid)"), (Shell::Room, " (room)")];
        let present = |kind: Shell| faces.iter().any(|(_, s)| *s == kind);
        let mixed = kinds.iter().filter(|(k, _)| present(*k)).count() > 1;
        for (kind, suffix) in kinds {
            if !present(kind) {
                continue;
            }
            let default = match (kind, m.both_sides) {
                (Shell::Open, Some(false)) => Sides::Front,
                (Shell::Open, _) => Sides::Both,
                _ => Sides::Front,
            };
            let sides = look.sides.unwrap_or(default);
            let name = match mixed {
                true => format!("{}{suffix}", self.name),
                false => self.name.clone(),
            };
            b.alias(&name, &self.name);
            let surface = Surface {
                name,
                reflectance: look.reflectance.or(m.reflectance).unwrap_or(REFLECTANCE),
                emission,
                reflectance_texture: texture,
                emission_texture,
                sides,
                patch_size: look.patch_size,
                solid: kind == Shell::Body && sides == Sides::Front,
            };
            let surface = b.add_surface(surface, &look)?;
            b.parts.facets.extend(faces.iter().filter(|(_, s)| *s == kind).map(|(f, _)| Facet {
                surface,
                plate: f.plate,
                uv: f.uv,
            }));
        }
        Ok(())
    }

    /// One pane a thickness: nodes of different scales show the same glass in different thicknesses.
    pub(crate) fn panes(&self, faces: Vec<&Face>, b: &mut Builder<'_>) -> Result<(), InputError> {
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        let shells = shells(&plates);
        if (0..plates.len()).any(|i| shells.of(i) != Shell::Open) {
            let text = format!(
                "pane '{}' is a closed slab: light goes through both its faces and the glass counts twice; give half the thickness, or region = true",
                self.name
            );
            b.note(Note::warning("closed-pane", text));
        }
        if self.keys().extinction.is_none() {
            self.material.lost_pane.iter().for_each(|text| b.note(Note::warning("alpha", text)));
        }
        let mut groups: BTreeMap<u64, Vec<Plate>> = BTreeMap::new();
        for f in faces {
            let t = self.thickness(f.scale)?;
            groups.entry(t.to_bits()).or_default().push(f.plate);
        }
        for (i, (bits, plates)) in groups.into_iter().enumerate() {
            let thickness = f64::from_bits(bits);
            let (extinction, albedo, emission) = self.matter(Some(thickness))?;
            b.add_pane_heat(self.keys().heat);
            b.parts.panes.push(Pane {
                name: match i {
                    0 => self.name.clone(),
                    _ => format!("{}#{}", self.name, i + 1),
                },
                plates,
                thickness,
                extinction,
                albedo,
                emission,
            });
        }
        Ok(())
    }

    fn keys(&self) -> PaneKeys {
        self.over.pane.flatten().unwrap_or_default()
    }

    fn thickness(&self, node_scale: f64) -> Result<f64, InputError> {
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| g.thickness);
        let of_file = of_file.map(|t| t * node_scale * self.scale);
        match self.keys().thickness.or(of_file) {
            Some(t) if t > 0.0 && t.is_finite() => Ok(t),
            _ => Err(self.error(format!(
                "material '{name}' lets light through, but its thickness is not known; write materials.\"{name}\".pane.thickness = 0.01 (metres), or materials.\"{name}\".pane = false for an opaque surface"
            ))),
        }
    }

    /// Extinction, albedo, emission of the glass, overrides first.
    fn matter(&self, thickness: Option<f64>) -> Result<(Bands, Bands, Bands), InputError> {
        let keys = self.keys();
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| match (g.loss, thickness) {
            (Loss::PerMetre(k), _) => Some(k.map(|x| x / self.scale)),
            (Loss::Passed(share), Some(t)) => Some(bands(|b| (-share[b].ln() / t).max(0.0))),
            (Loss::Passed(_), None) => None,
        });
        let extinction = keys.extinction.or(of_file).ok_or_else(|| {
            self.error(format!(
                "the extinction of material '{name}' is not known; write materials.\"{name}\".pane.extinction = [red, green, blue] (1/m)"
            ))
        })?;
        let albedo = keys.albedo.or(self.material.glass.map(|g| g.albedo));
        Ok((extinction, albedo.unwrap_or([0.0; 3]), keys.emission.unwrap_or([0.0; 3])))
    }

    /// A closed mesh that fills the voxmap.
    pub(crate) fn region(&self, faces: Vec<&Face>, b: &mut Builder<'_>) -> Result<(), InputError> {
        if !b.has_medium {
            return Err(self.error(format!(
                "material '{}' is to fill the medium, but there is none; add a [medium] around it",
                self.material.name
            )));
        }
        let thickness = faces.first().and_then(|f| self.thickness(f.scale).ok());
        let (extinction, albedo, emission) = self.matter(thickness)?;
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        check_closed(&plates).map_err(|what| self.error(what))?;
        b.fills.push(Fill {
            plates,
            matter: Matter {
                extinction: Some(extinction),
                albedo: Some(albedo),
                emission: Some(emission),
                source: None,
                heat: self.keys().heat,
            },
        });
        Ok(())
    }
}
