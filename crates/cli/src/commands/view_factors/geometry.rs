//! Facets and obstructions from meshes and from input files of View3D.

use std::path::Path;
use zonal_io::input::{
    FacetFile, View3dControls, View3dFile, View3dOutput, View3dSurface, View3dSurfaceKind, read_facets,
    read_view3d,
};
use zonal_io::output::ViewFactorFormat;
use zonal_math::Vec3;
use zonal_report::Failure;
use zonal_view_factors::{ConvexPolygon, FacetSet, convex_parts, without};

/// The facets of a computation.
pub(super) struct FactorGeometry {
    pub set: FacetSet,
    pub names: Vec<String>,
    pub emissivities: Vec<f64>,
    /// Of an input file of View3D.
    pub controls: Option<View3dControls>,
    pub notes: Vec<String>,
    /// Corners in the order in which they were added, m.
    corners: Vec<Vec3>,
}

impl FactorGeometry {
    fn new() -> FactorGeometry {
        FactorGeometry {
            set: FacetSet::new(),
            names: Vec::new(),
            emissivities: Vec::new(),
            controls: None,
            notes: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Numbers that tell one geometry from another.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let size = [self.set.len() as f64, self.corners.len() as f64];
        size.into_iter().chain(self.corners.iter().flat_map(|c| c.array()))
    }

    fn add_surface(&mut self, name: &str, emissivity: f64, parts: Vec<ConvexPolygon>) {
        // The surface's number separates its corners from those of the next.
        self.corners.push(Vec3::splat(self.set.len() as f64));
        self.corners.extend(parts.iter().flat_map(|p| p.corners()));
        self.set.add_parts(parts);
        self.names.push(name.to_string());
        self.emissivities.push(emissivity);
    }

    fn add_obstruction(&mut self, corners: &[Vec3]) {
        self.corners.push(Vec3::splat(-1.0));
        self.corners.extend(corners);
        self.set.add_obstruction(corners);
    }
}

/// The output format that a file of View3D asks for.
pub(super) fn format_of(controls: &View3dControls) -> ViewFactorFormat {
    match controls.output {
        View3dOutput::Text => ViewFactorFormat::View3dText,
        View3dOutput::Binary => ViewFactorFormat::View3dBinary,
        View3dOutput::SparseText => ViewFactorFormat::SparseText,
    }
}

/// Reads facets by the extension of their file, and obstructions from a mesh.
pub(super) fn read(input: &Path, obstructions: Option<&Path>) -> Result<FactorGeometry, Failure> {
    let is_view3d = input.extension().is_some_and(|e| e.eq_ignore_ascii_case("vs3"));
    let mut geometry = if is_view3d { of_view3d(input, read_view3d(input)?)? } else { of_mesh(input)? };
    if let Some(path) = obstructions {
        let mesh = read_facets(path)?;
        geometry.notes.extend(mesh.notes);
        mesh.facets.iter().flatten().for_each(|corners| geometry.add_obstruction(corners));
    }
    Ok(geometry)
}

fn of_mesh(path: &Path) -> Result<FactorGeometry, Failure> {
    of_facets(path, read_facets(path)?)
}

fn of_facets(path: &Path, mesh: FacetFile) -> Result<FactorGeometry, Failure> {
    let mut geometry = FactorGeometry::new();
    for (parts, name) in mesh.facets.iter().zip(&mesh.names) {
        let parts = parts.iter().flat_map(|c| convex_parts(c)).collect();
        geometry.add_surface(name, 1.0, parts);
    }
    geometry.notes = mesh.notes;
    if geometry.set.is_empty() {
        return Err(Failure::in_file(path, "this mesh has no facets; export it again"));
    }
    Ok(geometry)
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
    let mut geometry = FactorGeometry::new();
    for (k, s) in surfaces.iter().enumerate().filter(|(k, s)| radiating(s) && target(*k) == *k) {
        geometry.add_surface(&s.name, s.emissivity, std::mem::take(&mut parts[k]));
    }
    let hiding = surfaces.iter().filter(|s| s.kind == View3dSurfaceKind::Obstruction);
    hiding.for_each(|s| geometry.add_obstruction(&s.corners));
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
