//! One material of a mesh as surfaces, panes or a region of the medium.

use super::face_values::FaceValues;
use super::material_overrides::{MaterialOverride, PaneOverride};
use super::repeated_faces::without_opposite_faces;
use crate::input::mesh::missing_values::MissingValue;
use crate::input::mesh::model::{GlassAttenuation, ImageSource, MeshFace, MeshMaterial};
use crate::input::mesh::reflectance_limit::MAX_MODEL_REFLECTANCE;
use crate::input::mesh::shells::{OpenSides, ShellKind, check_closed, find_shells};
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::scene_reader::{InteriorFill, SceneReader};
use crate::input::scene::thermal::SceneMode;
use crate::input::toml::node::{TomlNode, TomlTable};
use std::collections::BTreeMap;
use zonal_math::Vec3;
use zonal_scene::{
    Bands, CornerNormals, DEFAULT_REFLECTANCE, Diagnostic, Facet, NormalMap, Pane, Plate, Sides, Surface,
    Transmission,
};

/// One material of a mesh and the part of the scene that describes it.
pub(crate) struct MaterialPart<'a, 'n> {
    pub(crate) table: &'a TomlTable<'n>,
    pub(crate) node: &'a TomlNode<'n>,
    pub(crate) name: String,
    pub(crate) material: &'a MeshMaterial,
    pub(crate) over: &'a MaterialOverride,
    /// Factor from the file's unit to metres.
    pub(crate) scale: f64,
    /// Index of the mesh's first face in the scene.
    pub(crate) first_face: usize,
    /// Sides of open parts.
    pub(crate) open_sides: OpenSides,
    /// Corner normals of the faces of the mesh.
    pub(crate) normals: &'a [CornerNormals],
    /// Values by face from files.
    pub(crate) values: &'a FaceValues,
    /// Properties of the material from files.
    pub(crate) of_material: SurfaceProperties,
}

impl MaterialPart<'_, '_> {
    fn error(&self, message: impl Into<String>) -> InputError {
        let offset = self.over.offset.unwrap_or(self.node.offset());
        self.table.source.error(offset, &self.table.key, message)
    }

    /// Refuses keys of surfaces on glass.
    pub(crate) fn check_glass(&self, mode: SceneMode) -> Result<(), InputError> {
        let Some(key) = &self.over.surface_key else { return Ok(()) };
        let (name, kind) =
            (&self.material.name, if self.over.region { "fills the medium" } else { "is a pane" });
        let pane_key = match key.name {
            "emission" => "emission",
            _ if self.over.region => "temperature or heat_source",
            _ => "temperature",
        };
        let inside = format!("put {pane_key} into materials.\"{name}\".pane = {{ … }}");
        let opaque = if self.over.region {
            String::new()
        } else {
            format!(", or write materials.\"{name}\".pane = false for an opaque surface")
        };
        let (reason, remedy) = match key.name {
            "emissivity" if mode == SceneMode::Thermal => {
                ("has no emissivity", format!("remove this key, and {inside}"))
            }
            "emission" | "temperature" | "heat_flux" | "net_power" => ("this key is of surfaces", inside),
            _ => ("this key is of surfaces", format!("remove it{opaque}")),
        };
        let message = format!("material '{name}' {kind}, and {reason}; {remedy}");
        Err(self.table.source.error(key.offset, &key.path, message))
    }

    /// The index of an image's texture, if there is an image.
    fn texture(
        &self,
        image: &Option<ImageSource>,
        reader: &mut SceneReader<'_>,
    ) -> Result<Option<usize>, InputError> {
        let read = image.as_ref().map(|p| reader.image(p));
        read.transpose().map_err(|f| self.error(f.to_string()))
    }

    /// The properties of the surfaces of these faces.
    fn properties(
        &self,
        faces: &[(&MeshFace, ShellKind)],
        of_surface: SurfaceProperties,
    ) -> SurfaceProperties {
        let given = self.over.properties.or(self.of_material);
        given.or(of_surface).or(self.values.representative(faces))
    }

    /// The values that an opaque material lacks in thermal mode.
    pub(crate) fn missing_of_surfaces(
        &self,
        faces: &[(&MeshFace, ShellKind)],
        of_surface: SurfaceProperties,
    ) -> Vec<MissingValue> {
        let p = self.properties(faces, of_surface);
        let condition = (p.condition.is_none() && p.convection.is_none()).then_some(MissingValue::Condition);
        let emissivity = p.reflectance.is_none().then_some(MissingValue::Emissivity);
        condition.into_iter().chain(emissivity).collect()
    }

    /// The value that a glass lacks.
    pub(crate) fn missing_of_glass(&self, faces: &[(&MeshFace, ShellKind)]) -> Option<MissingValue> {
        let thickness = faces.first().and_then(|(f, _)| self.thickness(f.scale).ok());
        if thickness.is_none() && !self.over.region {
            return Some(MissingValue::Thickness);
        }
        self.glass_properties(thickness).is_err().then_some(MissingValue::Extinction)
    }

    /// Adds one surface for each kind of shell: open, body, room.
    pub(crate) fn add_surfaces(
        &self,
        faces: Vec<(&MeshFace, ShellKind)>,
        of_surface: SurfaceProperties,
        reader: &mut SceneReader<'_>,
    ) -> Result<(), InputError> {
        let properties = self.properties(&faces, of_surface);
        let template = self.surface_template(&properties, reader)?;
        let present = |kind: ShellKind| faces.iter().any(|(_, s)| *s == kind);
        let mut wrong = 0;
        let mixed = ShellKind::VARIANTS.into_iter().filter(|k| present(*k)).count() > 1;
        for kind in ShellKind::VARIANTS.into_iter().filter(|k| present(*k)) {
            let of_kind: Vec<&MeshFace> = faces.iter().filter(|(_, s)| *s == kind).map(|(f, _)| *f).collect();
            let default = match (kind, self.material.double_sided) {
                _ if template.transmission.is_some() => Sides::Both,
                (ShellKind::Open, Some(false)) if self.open_sides == OpenSides::OfFile => Sides::Front,
                (ShellKind::Open, _) => Sides::Both,
                _ => Sides::Front,
            };
            let sides = properties.sides.unwrap_or(default);
            let name = if mixed { format!("{}{}", self.name, kind.name_suffix()) } else { self.name.clone() };
            reader.inherit_surface_place(&name, &self.name);
            let solid = kind == ShellKind::Solid && sides == Sides::Front;
            let surface = Surface { name, sides, solid, ..template.clone() };
            let name = surface.name.clone();
            let surface = reader.add_surface(surface, &properties)?;
            self.add_normal_map(surface, reader);
            let of_kind = if sides == Sides::Both && self.values.is_empty() {
                without_opposite_faces(of_kind, &name, reader)
            } else {
                of_kind
            };
            for f in of_kind {
                wrong += self.add_facet(f, surface, &properties, reader);
            }
        }
        if wrong > 0 {
            let text = format!(
                "surface '{}': {wrong} vertex normals are more than 80° from their faces; pictures show flat corners there",
                self.name
            );
            reader.note(Diagnostic::note("normals", text));
        }
        Ok(())
    }

    /// Adds a face to a surface; returns the number of its vertex normals that are wrong.
    fn add_facet(
        &self,
        f: &MeshFace,
        surface: usize,
        properties: &SurfaceProperties,
        reader: &mut SceneReader<'_>,
    ) -> usize {
        let given = self.over.properties.or(self.of_material);
        let (facet, mut values) = (reader.parts.facets.len(), self.values.of_face(f.face, &given));
        if let Some(a) = properties.solar_absorptance {
            let (bands, block) = (&reader.parts.bands, reader.parts.block);
            values.reflectance = values.reflectance.map(|r| bands.with_solar_value(block, r, 1.0 - a));
        }
        reader.parts.faces.push(facet, self.first_face + f.face, values);
        let own = Facet { surface, plate: f.plate, uv: f.uv };
        let normals = f.normals.and_then(|k| self.normals.get(k as usize));
        let normals = normals.map(|n| n.map(|n| Vec3::from_array(n.map(f64::from))));
        let wrong = normals.map_or(0, |n| reader.parts.shading.push(facet, &own, &n));
        reader.parts.facets.push(own);
        wrong
    }

    /// Adds the normal map of the material to a surface. Thermal mode has no textures.
    fn add_normal_map(&self, surface: usize, reader: &mut SceneReader<'_>) {
        let own = self.material.normal_map.as_ref().filter(|_| reader.mode() != SceneMode::Thermal);
        let Some((image, scale)) = own else { return };
        match reader.normal_map(image) {
            Ok(texture) => {
                reader.parts.shading.maps.push(NormalMap { surface, texture, scale: *scale });
            }
            Err(e) => {
                let name = &self.material.name;
                let text =
                    format!("material '{name}': its normal map is not read ({e}); pictures show it smooth");
                reader.note(Diagnostic::note("normals", text));
            }
        }
    }

    /// The surface of this material but for its name, sides and solidity; adds warnings about contents that are not read.
    fn surface_template(
        &self,
        properties: &SurfaceProperties,
        reader: &mut SceneReader<'_>,
    ) -> Result<Surface, InputError> {
        let m = self.material;
        m.opaque_warning.iter().for_each(|text| reader.note(Diagnostic::warning("alpha", text)));
        if properties.reflectance.is_none() && m.reflectance.is_none() {
            let missing = m.missing_warning.iter();
            missing.for_each(|text| reader.note(Diagnostic::warning("default-material", text)));
        }
        let light_mode = reader.mode() == SceneMode::Light;
        // A reflectance or texture of the scene file replaces the material's texture; thermal mode has no textures.
        let own_texture = properties.reflectance.is_none() && properties.texture.is_none() && light_mode;
        let reflectance_texture =
            if own_texture { self.texture(&m.texture, reader)? } else { properties.texture };
        let has_limited_texture = own_texture && reflectance_texture.is_some_and(|t| reader.is_limited(t));
        if light_mode && properties.reflectance.is_none() && (m.is_limited || has_limited_texture) {
            self.note_limited_reflectance(reader);
        }
        let emission_texture = match properties.emission {
            None if light_mode => self.texture(&m.emission_texture, reader)?,
            _ => None,
        };
        Ok(Surface {
            transmission: self.transmission(properties, reader)?,
            reflectance: properties.reflectance.or(m.reflectance).unwrap_or(DEFAULT_REFLECTANCE),
            emission: properties.emission.unwrap_or(if light_mode { m.emission } else { Bands::ZERO }),
            reflectance_texture,
            emission_texture,
            patch_size: properties.patch_size,
            ..Surface::default()
        })
    }

    /// The diffuse transmission of its surfaces: that of the scene file, or of the material in light mode.
    fn transmission(
        &self,
        properties: &SurfaceProperties,
        reader: &mut SceneReader<'_>,
    ) -> Result<Option<Transmission>, InputError> {
        let Some((transmittance, texture)) = &self.material.transmittance else {
            return Ok(properties.transmission());
        };
        if reader.mode() != SceneMode::Light {
            let name = &self.material.name;
            let text =
                format!("material '{name}' transmits diffusely in its file; in thermal mode it is opaque");
            reader.note(Diagnostic::warning("transmission", text));
            return Ok(properties.transmission());
        }
        if properties.transmittance.is_some() {
            return Ok(properties.transmission());
        }
        Ok(Some(Transmission { transmittance: *transmittance, texture: self.texture(texture, reader)? }))
    }

    fn note_limited_reflectance(&self, reader: &mut SceneReader<'_>) {
        let text = format!(
            "material '{}' reflects more than {MAX_MODEL_REFLECTANCE} of the light in its file; {MAX_MODEL_REFLECTANCE} is taken, since light that no wall absorbs ends nowhere: give the reflectance in the scene to replace it",
            self.material.name
        );
        reader.note(Diagnostic::note("material-limit", text));
    }

    /// Adds one pane for each thickness: nodes of different scales show one glass in different thicknesses.
    pub(crate) fn add_panes(
        &self,
        faces: Vec<&MeshFace>,
        reader: &mut SceneReader<'_>,
    ) -> Result<(), InputError> {
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        let shells = find_shells(&plates);
        let is_closed = (0..plates.len()).any(|i| shells.of(i) != ShellKind::Open);
        let mut absorbs = false;
        let mut by_thickness: BTreeMap<u64, Vec<Plate>> = BTreeMap::new();
        for f in faces {
            let t = self.thickness(f.scale)?;
            by_thickness.entry(t.to_bits()).or_default().push(f.plate);
        }
        for (i, (bits, plates)) in by_thickness.into_iter().enumerate() {
            let thickness = f64::from_bits(bits);
            let [extinction, albedo, emission] = self.glass_properties(Some(thickness))?;
            absorbs |= extinction.any(|k| k > 0.0);
            reader.add_pane_condition(self.pane_override().condition);
            reader.parts.panes.push(Pane {
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
        if is_closed && absorbs {
            let text = format!(
                "pane '{}' is a closed slab: light goes through both its faces and the glass counts twice; give half the thickness, or region = true",
                self.name
            );
            reader.note(Diagnostic::warning("closed-pane", text));
        }
        Ok(())
    }

    fn pane_override(&self) -> PaneOverride {
        self.over.pane.flatten().unwrap_or_default()
    }

    /// Thickness of the glass at a node of this scale, m.
    fn thickness(&self, node_scale: f64) -> Result<f64, InputError> {
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| g.thickness);
        let of_file = of_file.map(|t| t * node_scale * self.scale);
        match self.pane_override().thickness.or(of_file) {
            Some(t) if t > 0.0 && t.is_finite() => Ok(t),
            _ => Err(self.error(format!(
                "material '{name}' lets light through, but its thickness is not known; write materials.\"{name}\".pane.thickness = 0.01 (metres), or materials.\"{name}\".pane = false for an opaque surface"
            ))),
        }
    }

    /// Extinction, albedo and emission of the glass; overrides take precedence.
    fn glass_properties(&self, thickness: Option<f64>) -> Result<[Bands; 3], InputError> {
        let pane = self.pane_override();
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| match (g.attenuation, thickness) {
            (GlassAttenuation::Coefficient(k), _) => Some(k / self.scale),
            (GlassAttenuation::Transmittance(transmittance), Some(t)) => {
                Some(transmittance.map(|x| (-x.ln() / t).max(0.0)))
            }
            (GlassAttenuation::Transmittance(_), None) => None,
        });
        let extinction = pane.extinction.or(of_file).ok_or_else(|| {
            self.error(format!(
                "the extinction of material '{name}' is not known; write materials.\"{name}\".pane.extinction = [red, green, blue] (1/m)"
            ))
        })?;
        let albedo = pane.albedo.or(self.material.glass.map(|g| g.albedo));
        Ok([extinction, albedo.unwrap_or(Bands::ZERO), pane.emission.unwrap_or(Bands::ZERO)])
    }

    /// Adds a closed mesh that fills the medium.
    pub(crate) fn add_region(
        &self,
        faces: Vec<&MeshFace>,
        reader: &mut SceneReader<'_>,
    ) -> Result<(), InputError> {
        if !reader.has_medium {
            return Err(self.error(format!(
                "material '{}' is to fill the medium, but there is none; add a [medium] around it",
                self.material.name
            )));
        }
        let thickness = faces.first().and_then(|f| self.thickness(f.scale).ok());
        let [extinction, albedo, emission] = self.glass_properties(thickness)?;
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        check_closed(&plates).map_err(|message| self.error(message))?;
        reader.interior_fills.push(InteriorFill {
            plates,
            properties: MediumProperties {
                extinction: Some(extinction),
                albedo: Some(albedo),
                emission: Some(emission),
                source: None,
                condition: self.pane_override().condition,
                gas: Default::default(),
            },
        });
        Ok(())
    }
}
