//! The elements of a PLY file as a mesh.

use super::header::{PlyElement, PlyHeader};
use crate::files::FileSource;
use crate::input::mesh::model::MeshData;
use crate::input::mesh::polygon::PolygonCorner;
use crate::input::mesh::polygon_list::PolygonList;
use crate::input::reading::error::FileFault;
use crate::input::reading::number_cursor::{NumberCursor, NumberEncoding};
use std::path::Path;
use zonal_math::Vec3;

/// Largest file, bytes.
const MAX_PLY_FILE_BYTES: u64 = 1 << 30;
/// Names of the list of a face's corners.
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Names of the texture coordinates of a vertex.
const TEXTURE_COORDINATES: [[&str; 3]; 2] = [["s", "u", "texture_u"], ["t", "v", "texture_v"]];

/// Reads a PLY file; `file` names it in messages.
pub(crate) fn read_mesh_file(files: FileSource<'_>, path: &Path, file: &str) -> Result<MeshData, FileFault> {
    let bytes = files.read(path, MAX_PLY_FILE_BYTES).map_err(|e| FileFault::new(file, "", e))?;
    let header = PlyHeader::parse(file, &bytes)?;
    check_elements(file, &header)?;
    let cursor = NumberCursor::new(file, &bytes, header.end, header.encoding);
    let mut reader = PlyReader {
        cursor,
        vertices: Vec::new(),
        normals: Vec::new(),
        faces: Vec::new(),
        lists: FaceLists::default(),
    };
    for element in &header.elements {
        reader.check_size(element)?;
        match element.name.as_str() {
            "vertex" => reader.read_vertices(element)?,
            "face" => reader.read_faces(element)?,
            _ => reader.read_rows(element, |_, _, _, _| Ok(()))?,
        }
    }
    let mut list = reader.polygons(file)?;
    let excess = reader.cursor.rest().iter().filter(|b| !b.is_ascii_whitespace()).count();
    if excess > 0 {
        list.note(format!("{file}: {excess} byte(s) behind the declared rows were not read"));
    }
    add_notes(file, &header, &mut list);
    list.finish(file)
}

/// Refuses files without vertices or without faces.
fn check_elements(file: &str, header: &PlyHeader) -> Result<(), FileFault> {
    let fault = |message: String| Err(FileFault::new(file, "header", message));
    let find = |name: &str| header.elements.iter().find(|e| e.name == name);
    let Some(vertices) = find("vertex") else {
        return fault("this file has no element vertex; export the mesh again".into());
    };
    if ["x", "y", "z"].iter().any(|axis| vertices.position(&[axis]).is_none()) {
        return fault("its vertices have no x, y and z; export the mesh again".into());
    }
    let faces = find("face").filter(|e| e.count > 0);
    let Some(faces) = faces else {
        if find("tristrips").is_some() {
            let message = "this file has strips of triangles, which are not read; open it in MeshLab and export it with faces";
            return fault(message.into());
        }
        return fault(format!(
            "this file is a cloud of {} points without faces; reconstruct its surface first (MeshLab: Filters, Remeshing, Surface Reconstruction: Screened Poisson) and save that",
            vertices.count
        ));
    };
    let corners = faces.position(&CORNER_LISTS).filter(|k| faces.properties[*k].length.is_some());
    match corners {
        Some(_) => Ok(()),
        None => fault("its faces have no list vertex_indices; export the mesh again".into()),
    }
}

/// Notes of contents that are not read.
fn add_notes(file: &str, header: &PlyHeader, list: &mut PolygonList) {
    for (name, noun) in [("vertex", "vertices"), ("face", "faces")] {
        let is_coloured = |e: &PlyElement| e.name == name && e.position(&["red", "diffuse_red"]).is_some();
        if header.elements.iter().any(is_coloured) {
            list.note(format!(
                "{file}: the colours of its {noun} are not read; write reflectance in the scene"
            ));
        }
    }
    if let Some(name) = header.textures.first() {
        list.note(format!(
            "{file}: its picture '{name}' is not read; write texture = \"{name}\" in the scene"
        ));
    }
}

/// A vertex: position and texture coordinates.
type Vertex = PolygonCorner;

/// The faces of a file while it is read.
#[derive(Default)]
struct FaceLists {
    /// Corners of all faces, as indices of vertices.
    corners: Vec<u64>,
    /// Texture coordinates of all faces, u and v.
    coordinates: Vec<f64>,
}

/// One face: the ends of its lists in [`FaceLists`].
struct FaceEnds {
    corners: usize,
    coordinates: usize,
}

/// Reads the elements one after the other.
struct PlyReader<'a> {
    cursor: NumberCursor<'a>,
    vertices: Vec<Vertex>,
    /// Normals of the vertices; empty without.
    normals: Vec<Vec3>,
    faces: Vec<FaceEnds>,
    lists: FaceLists,
}

impl PlyReader<'_> {
    /// Compares the declared rows with the bytes that are left.
    fn check_size(&self, element: &PlyElement) -> Result<(), FileFault> {
        let least = element.min_row_bytes(self.cursor.encoding).saturating_mul(element.count);
        let left = self.cursor.rest().len();
        // The last word of a text may lack its blank.
        if least > left + usize::from(self.cursor.encoding == NumberEncoding::Text) {
            let (count, name) = (element.count, &element.name);
            return Err(self.cursor.fault(format!(
                "{count} rows of {name} take at least {least} bytes, but {left} are left; the file is cut short: export the mesh again"
            )));
        }
        Ok(())
    }

    /// Reads all rows of an element: `take` gets the reader, the row, the index of each property and its values.
    fn read_rows(
        &mut self,
        element: &PlyElement,
        mut take: impl FnMut(&mut Self, usize, usize, &[f64]) -> Result<(), FileFault>,
    ) -> Result<(), FileFault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut values = Vec::new();
        for row in 0..element.count {
            for (k, property) in element.properties.iter().enumerate() {
                let length = property.length.map_or(Ok(1), |of| self.cursor.count(of))?;
                values.clear();
                for _ in 0..length {
                    values.push(self.cursor.number(property.value)?);
                }
                take(self, row, k, &values)?;
            }
        }
        Ok(())
    }

    fn read_vertices(&mut self, element: &PlyElement) -> Result<(), FileFault> {
        let position = ["x", "y", "z"].map(|name| element.position(&[name]));
        let coordinates = TEXTURE_COORDINATES.map(|names| element.position(&names));
        let last = element.properties.len() - 1;
        let normal = ["nx", "ny", "nz"].map(|name| element.position(&[name]));
        let has_normals = normal.iter().all(Option::is_some);
        let mut vertex = [f64::NAN, f64::NAN, f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0];
        let slots = position.into_iter().chain(coordinates).chain(normal).collect::<Vec<_>>();
        self.read_rows(element, |reader, row, k, values| {
            for (slot, property) in vertex.iter_mut().zip(&slots) {
                if *property == Some(k) {
                    *slot = values.first().copied().unwrap_or(f64::NAN);
                }
            }
            if k < last {
                return Ok(());
            }
            if !vertex[..5].iter().all(|x| x.is_finite()) {
                let message =
                    format!("vertex {row} has a number that is not finite; mend it or export the mesh again");
                return Err(reader.cursor.fault(message));
            }
            let [x, y, z, u, v, n @ ..] = vertex;
            // PLY's v runs up, a texture's down.
            reader.vertices.push((Vec3::from_array([x, y, z]), [u, 1.0 - v]));
            if has_normals {
                // Programs that know no normal of a vertex write one that is not a number.
                let normal = Vec3::from_array(n);
                reader.normals.push(if normal.is_finite() { normal } else { Vec3::ZERO });
            }
            Ok(())
        })
    }

    fn read_faces(&mut self, element: &PlyElement) -> Result<(), FileFault> {
        let corners = element.position(&CORNER_LISTS);
        let coordinates = element.position(&["texcoord"]);
        let last = element.properties.len().saturating_sub(1);
        self.read_rows(element, |reader, row, k, values| {
            if corners == Some(k) {
                for index in values {
                    if index.fract() != 0.0 || *index < 0.0 {
                        let message =
                            format!("face {row}: {index} is no index of a vertex; export the mesh again");
                        return Err(reader.cursor.fault(message));
                    }
                    reader.lists.corners.push(*index as u64);
                }
            } else if coordinates == Some(k) {
                reader.lists.coordinates.extend(values);
            }
            if k == last {
                let lists = &reader.lists;
                let ends = FaceEnds { corners: lists.corners.len(), coordinates: lists.coordinates.len() };
                reader.faces.push(ends);
            }
            Ok(())
        })
    }

    /// All faces as polygons.
    fn polygons(&self, file: &str) -> Result<PolygonList, FileFault> {
        let mut list = PolygonList::default();
        let material = list.material("default");
        let (mut corners, mut coordinates) = (0, 0);
        for (row, ends) in self.faces.iter().enumerate() {
            let fault = |message: String| FileFault::new(file, format!("face {row}"), message);
            let own = self.lists.coordinates[coordinates..ends.coordinates].as_chunks::<2>().0;
            let indices = &self.lists.corners[corners..ends.corners];
            let mut polygon = Vec::with_capacity(indices.len());
            for (k, index) in indices.iter().enumerate() {
                let vertex = usize::try_from(*index).ok().and_then(|i| self.vertices.get(i));
                let Some((position, of_vertex)) = vertex else {
                    let count = self.vertices.len();
                    return Err(fault(format!(
                        "vertex index {index} is out of range: there are {count} vertices; mend the index"
                    )));
                };
                let of_corner = own.get(k).filter(|_| own.len() == indices.len());
                let finite = of_corner.filter(|uv| uv.iter().all(|x| x.is_finite()));
                polygon.push((*position, finite.map_or(*of_vertex, |[u, v]| [*u, 1.0 - v])));
            }
            let normal = |index: &u64| self.normals.get(*index as usize).copied();
            let normals = indices.iter().filter_map(normal).collect::<Vec<_>>();
            list.push_smooth(material, &polygon, &normals).map_err(fault)?;
            (corners, coordinates) = (ends.corners, ends.coordinates);
        }
        Ok(list)
    }
}
