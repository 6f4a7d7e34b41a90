//! Facets and obstructions from meshes and from input files of View3D.

use crate::Error;
use std::path::Path;
use zonal_io::input::{
    FacetFile, View3dControls, View3dFile, View3dOutput, View3dSurface, View3dSurfaceKind, read_facets,
    read_view3d,
};
use zonal_io::output::ViewFactorFormat;
use zonal_math::Vec3;
use zonal_report::Failure;
use zonal_scene::Plate;
use zonal_scene::topology::Topology;
use zonal_view_factors::{ConvexPolygon, FacetSet, convex_parts, without};

/// The facets of a computation.
#[derive(Clone, Debug, Default)]
pub struct FactorGeometry {
    /// Surfaces and obstructions, m.
    pub set: FacetSet,
    /// Name of each surface; of meshes that of its part or material.
    pub names: Vec<String>,
    /// Emissivity of each surface; 1 in meshes.
    pub emissivities: Vec<f64>,
    /// Of an input file of View3D.
    pub controls: Option<View3dControls>,
    /// Notes of the readers.
    pub notes: Vec<String>,
}

impl FactorGeometry {
    /// True if the file of the geometry states that it is an enclosure.
    #[must_use]
    pub fn is_enclosure(&self) -> bool {
        self.controls.as_ref().is_some_and(|c| c.enclosure)
    }

    /// The output format that the file of the geometry asks for.
    #[must_use]
    pub fn format(&self) -> Option<ViewFactorFormat> {
        Some(match self.controls.as_ref()?.output {
            View3dOutput::Text => ViewFactorFormat::View3dText,
            View3dOutput::Binary => ViewFactorFormat::View3dBinary,
            View3dOutput::SparseText => ViewFactorFormat::SparseText,
        })
    }

    /// Adds a surface that is the union of polygons.
    pub fn add_surface(&mut self, name: &str, emissivity: f64, parts: Vec<ConvexPolygon>) {
        self.set.add_parts(parts);
        self.names.push(name.to_string());
        self.emissivities.push(emissivity);
    }

    /// Adds the back of every surface, with its name and emissivity, after all fronts.
    pub fn add_backs(&mut self) {
        self.set.add_backs();
        let backs: Vec<String> = self.names.iter().map(|n| format!("{n} (back)")).collect();
        self.names.extend(backs);
        self.emissivities.extend_from_within(..);
    }

    /// Adds the facets of a mesh, which hide from both sides and have no factors.
    pub fn add_obstructions(&mut self, mesh: FacetFile) {
        self.notes.extend(mesh.notes);
        mesh.facets.iter().flatten().for_each(|corners| {
            self.set.add_obstruction(corners);
        });
    }
}

/// Reads facets by the extension of their file, and obstructions from a mesh.
///
/// # Errors
/// If a file cannot be read, has no facets, or needs what is not computed.
pub fn read(input: &Path, obstructions: Option<&Path>) -> Result<FactorGeometry, Error> {
    let is_view3d = input.extension().is_some_and(|e| e.eq_ignore_ascii_case("vs3"));
    let mut geometry = if is_view3d { of_view3d(input, read_view3d(input)?)? } else { of_mesh(input)? };
    if let Some(path) = obstructions {
        geometry.add_obstructions(read_facets(path)?);
    }
    Ok(geometry)
}

fn of_mesh(path: &Path) -> Result<FactorGeometry, Error> {
    Ok(of_facets(path, read_facets(path)?)?)
}

fn of_facets(path: &Path, mesh: FacetFile) -> Result<FactorGeometry, Failure> {
    let mut geometry = FactorGeometry::default();
    for (parts, name) in mesh.facets.iter().zip(&mesh.names) {
        let parts = parts.iter().flat_map(|c| convex_parts(c)).collect();
        geometry.add_surface(name, 1.0, parts);
    }
    geometry.notes = mesh.notes;
    geometry.notes.extend(repeated_note(&mesh.facets));
    if geometry.set.is_empty() {
        return Err(Failure::in_file(path, "this mesh has no facets; export it again"));
    }
    Ok(geometry)
}

/// A note about facets with the corners of an earlier one in the same order: they lie in one place, and their factors are those of both.
fn repeated_note(facets: &[Vec<Vec<Vec3>>]) -> Option<String> {
    let (mut plates, mut face_of) = (Vec::new(), Vec::new());
    for (face, parts) in facets.iter().enumerate() {
        for corners in parts.iter().filter(|c| c.len() >= 3) {
            let fan = corners[1..].windows(2).map(|w| Plate::triangle(corners[0], w[0], w[1]));
            plates.extend(fan);
            face_of.resize(plates.len(), face);
        }
    }
    let found = Topology::of(&plates, &face_of).repeated_faces;
    let first = found.first_place()?;
    Some(format!(
        "{} facet(s) repeat an earlier one (first: {first}): both take their view factors to all others, so that areas count twice; remove them from the file",
        found.count
    ))
}

fn of_view3d(path: &Path, file: View3dFile) -> Result<FactorGeometry, Failure> {
    let surfaces = &file.surfaces;
    if let Some(mask) = surfaces.iter().find(|s| s.kind == View3dSurfaceKind::Mask) {
        let message = format!(
            "surface {}: masks are not computed; give the covered part as a null surface (N)",
            mask.name
        );
        return Err(Failure::in_file(path, message));
    }
    let radiating = |s: &View3dSurface| s.kind == View3dSurfaceKind::Radiating;
    // Surfaces that are combined are parts of the first of them.
    let target = |k: usize| surfaces[k].combined_with.unwrap_or(k);
    let mut parts: Vec<Vec<ConvexPolygon>> = vec![Vec::new(); surfaces.len()];
    for (k, s) in surfaces.iter().enumerate().filter(|(_, s)| radiating(s)) {
        let inner = surfaces.iter().filter(|o| o.base == Some(k)).flat_map(|o| convex_parts(&o.corners));
        let rest = inner.fold(convex_parts(&s.corners), |rest, p| without(rest, &p));
        parts[target(k)].extend(rest);
    }
    let mut geometry = FactorGeometry::default();
    for (k, s) in surfaces.iter().enumerate().filter(|(k, s)| radiating(s) && target(*k) == *k) {
        geometry.add_surface(&s.name, s.emissivity, std::mem::take(&mut parts[k]));
    }
    let hiding = surfaces.iter().filter(|s| s.kind == View3dSurfaceKind::Obstruction);
    hiding.for_each(|s| {
        geometry.set.add_obstruction(&s.corners);
    });
    if geometry.set.is_empty() {
        return Err(Failure::in_file(path, "this file has no radiating surface (S); add one"));
    }
    geometry.notes = file.notes;
    let c = &file.controls;
    if c.row.is_some() || c.column.is_some() {
        geometry.notes.push("row, col: all factors are computed".into());
    }
    if c.max_distance.is_some() {
        geometry.notes.push("maxD: all distances are computed".into());
    }
    geometry.controls = Some(file.controls);
    Ok(geometry)
}
