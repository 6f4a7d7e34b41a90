//! Survey of a mesh file without a scene: extent, materials, closed and open parts, doubled faces, cameras.
//!
//! Everything is in the unit and the axes of the file. [`ModelSurvey::axis_areas`] sums the area of the faces seen along each axis, Σ A |n_k|: in buildings floors
//! and ceilings make it largest along the vertical.

use crate::file_stamps::FileRecord;
use crate::files::FileSource;
use crate::input::mesh::model::{MeshData, MeshMaterial};
use crate::input::mesh::shells::{ShellKind, TurnedPart, find_shells, turned_parts};
use crate::input::mesh_files::load::read_mesh_file;
use crate::input::reading::error::{FileFault, InputError};
use std::path::Path;
use zonal_math::Vec3;
use zonal_scene::topology::{FaceCopy, Topology, copies};
use zonal_scene::{Bands, Camera, Plate};

/// Extent, materials, parts and cameras of a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelSurvey {
    /// Lower and upper corner.
    pub bounds: (Vec3, Vec3),
    /// Number of polygons.
    pub faces: usize,
    /// The materials that faces have, those of large areas first.
    pub materials: Vec<SurveyedMaterial>,
    /// Σ A |n_k| along the axes, in squares of the file's unit.
    pub axis_areas: [f64; 3],
    /// Open and closed parts of the opaque faces.
    pub parts: PartCounts,
    /// Number of faces with the corners of another, in the same or the reverse order.
    pub doubled_faces: usize,
    /// Defects of the opaque faces, in the file's unit.
    pub topology: Topology,
    /// The cameras of the file.
    pub cameras: Vec<Camera>,
    /// Repairs and ignored contents.
    pub notes: Vec<String>,
}

/// A material of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyedMaterial {
    /// Name.
    pub name: String,
    /// Number of faces.
    pub faces: usize,
    /// Area of its faces in squares of the file's unit.
    pub area: f64,
    /// Reflectance; `None` if the file has none.
    pub reflectance: Option<Bands>,
    /// True if an image gives the reflectance of points.
    pub is_textured: bool,
    /// Emission in W/m², 0 without.
    pub emission: Bands,
    /// True if it lets light through.
    pub is_glass: bool,
    /// True of a glass whose thickness the file does not give.
    pub lacks_thickness: bool,
    /// True if the file says that both sides are seen, false if the front only; `None` if it does not say.
    pub double_sided: Option<bool>,
    /// Transparency of the file that is not read, as a message.
    pub unread_transparency: Option<String>,
}

/// Connected parts of the opaque faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartCounts {
    /// Parts with an edge that belongs to one face only, or without volume.
    pub open: usize,
    /// Closed parts whose normals point outward.
    pub solids: usize,
    /// Closed parts whose normals point inward: rooms, or bodies that are turned inside out.
    pub rooms: usize,
    /// Closed parts with outward normals that contain most of the model: rooms that are turned inside out.
    pub inverted_rooms: usize,
    /// Closed parts with inward normals that are small: bodies that are turned inside out.
    pub inverted_solids: usize,
    /// Edges whose two faces have opposite orientations.
    pub flipped_edges: usize,
    /// Area of the open parts over that of all.
    pub open_area_fraction: f64,
}

/// Reads a mesh file by its extension and reports what it contains.
///
/// # Errors
/// The file cannot be read or is not a mesh.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-survey-{}.obj", std::process::id()));
/// std::fs::write(&path, "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
/// let survey = zonal_io::input::survey_model(&path)?;
/// assert_eq!((survey.faces, survey.parts.open, survey.materials[0].area), (1, 1, 2.0));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn survey_model(path: &Path) -> Result<ModelSurvey, InputError> {
    FileRecord::default().survey_model(path)
}

impl FileRecord {
    /// As [`survey_model`].
    ///
    /// # Errors
    /// As [`survey_model`].
    pub fn survey_model(&self, path: &Path) -> Result<ModelSurvey, InputError> {
        let file = path.display().to_string();
        let mesh = read_mesh_file(FileSource::recorded(self), path, &file).map_err(FileFault::into_error)?;
        Ok(ModelSurvey::of(mesh))
    }
}

impl ModelSurvey {
    fn of(mesh: MeshData) -> ModelSurvey {
        let plates: Vec<Plate> = mesh.faces.iter().map(|f| f.plate).filter(|p| p.area() > 0.0).collect();
        let bounds = bounds_of(&plates);
        let mut axis_areas = [0.0; 3];
        for p in &plates {
            let (area, normal) = (p.area(), p.normal());
            (0..3).for_each(|k| axis_areas[k] += area * normal[k].abs());
        }
        let mut plates_of_material = vec![Vec::new(); mesh.materials.len()];
        mesh.faces.iter().for_each(|f| plates_of_material[f.material].push(f.plate));
        let used = mesh.materials.iter().zip(&plates_of_material).filter(|(_, plates)| !plates.is_empty());
        let materials = used.map(|(material, plates)| SurveyedMaterial::of(material, plates));
        let mut materials: Vec<SurveyedMaterial> = materials.collect();
        materials.sort_by(|a, b| b.area.total_cmp(&a.area));
        let is_opaque = |f: &&crate::input::mesh::model::MeshFace| {
            let m = &mesh.materials[f.material];
            !m.is_glass() && m.alpha.is_none()
        };
        let with_area = |f: &&crate::input::mesh::model::MeshFace| f.plate.area() > 0.0;
        let all: Vec<_> = mesh.faces.iter().filter(is_opaque).filter(with_area).collect();
        let numbers: Vec<usize> = all.iter().map(|f| f.face).collect();
        let opaque: Vec<Plate> = all.iter().map(|f| f.plate).collect();
        let topology = Topology::of(&opaque, &numbers);
        // The scene drops repeated faces.
        let copies = copies(&opaque, &numbers, &|_| 0);
        let kept = opaque.iter().zip(&copies).filter(|(_, c)| !matches!(c, Some(FaceCopy::Repeated(_))));
        let kept: Vec<Plate> = kept.map(|(p, _)| *p).collect();
        ModelSurvey {
            bounds,
            faces: mesh.face_count,
            materials,
            axis_areas,
            parts: PartCounts::of(&kept, bounds.0, bounds.1),
            doubled_faces: topology.repeated_faces.count + topology.opposite_faces.count,
            topology,
            cameras: mesh.cameras,
            notes: mesh.notes,
        }
    }
}

impl SurveyedMaterial {
    fn of(m: &MeshMaterial, plates: &[Plate]) -> SurveyedMaterial {
        SurveyedMaterial {
            name: m.name.clone(),
            faces: plates.len(),
            area: plates.iter().map(Plate::area).sum(),
            reflectance: m.reflectance,
            is_textured: m.texture.is_some(),
            emission: m.emission,
            is_glass: m.is_glass(),
            lacks_thickness: m.is_glass() && m.glass.is_some_and(|g| g.thickness.is_none()),
            double_sided: m.double_sided,
            unread_transparency: m.opaque_warning.clone(),
        }
    }
}

impl PartCounts {
    fn of(plates: &[Plate], low: Vec3, high: Vec3) -> PartCounts {
        let shells = find_shells(plates);
        let mut out = PartCounts::default();
        let (mut open_area, mut area) = (0.0, 0.0);
        for (s, turned) in shells.shells().iter().zip(turned_parts(plates, &shells, low, high)) {
            area += s.area;
            out.flipped_edges += s.flipped_edges;
            match (turned, s.kind) {
                (Some(TurnedPart::Room), _) => out.inverted_rooms += 1,
                (Some(TurnedPart::Solid), _) => out.inverted_solids += 1,
                (None, ShellKind::Open) => {
                    open_area += s.area;
                    out.open += 1;
                }
                (None, ShellKind::Solid) => out.solids += 1,
                (None, ShellKind::Enclosure) => out.rooms += 1,
            }
        }
        out.open_area_fraction = if area > 0.0 { open_area / area } else { 0.0 };
        out
    }
}

fn bounds_of(plates: &[Plate]) -> (Vec3, Vec3) {
    let corners = plates.iter().map(Plate::bounds);
    corners.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default()
}
