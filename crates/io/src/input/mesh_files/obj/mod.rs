//! Wavefront OBJ: positions, texture coordinates, normals, polygons, materials.

mod mtl;

use crate::files::FileSource;
use crate::input::mesh::model::{MeshData, MeshFace, MeshMaterial};
use crate::input::mesh::polygon::{PolygonCorner, push_smooth_polygon};
use crate::input::reading::error::FileFault;
use std::collections::HashMap;
use std::path::Path;
use zonal_math::{Vec3, vec3};

/// Largest number of corners of a polygon; it bounds the cost of ear clipping.
const MAX_POLYGON_CORNERS: usize = 1024;

/// Reads an OBJ file's text; material libraries and images are looked for beside `path`.
pub(super) fn parse(
    files: FileSource<'_>,
    path: &Path,
    file: &str,
    text: &str,
) -> Result<MeshData, FileFault> {
    let mut reader = ObjReader {
        files,
        file,
        folder: path.parent().unwrap_or(Path::new("")),
        mesh: MeshData::default(),
        positions: Vec::new(),
        coordinates: Vec::new(),
        normals: Vec::new(),
        library: HashMap::new(),
        used: HashMap::new(),
        current: None,
        crossed: 0,
    };
    let mut pending = String::new();
    for (number, line) in text.lines().enumerate() {
        // Join lines that end with a backslash.
        let line = line.trim_end();
        if let Some(part) = line.strip_suffix('\\') {
            pending.push_str(part);
            pending.push(' ');
            continue;
        }
        if pending.is_empty() {
            reader.line(number + 1, line)?;
        } else {
            pending.push_str(line);
            reader.line(number + 1, &std::mem::take(&mut pending))?;
        }
    }
    reader.line(text.lines().count(), &pending)?;
    if reader.mesh.faces.is_empty() {
        return Err(FileFault::new(file, "", "this mesh has no faces; export it again"));
    }
    if reader.crossed > 0 {
        let n = reader.crossed;
        reader.mesh.notes.push(format!("{file}: {n} polygons cross themselves and were cut as fans"));
    }
    Ok(reader.mesh)
}

struct ObjReader<'a> {
    files: FileSource<'a>,
    file: &'a str,
    folder: &'a Path,
    mesh: MeshData,
    positions: Vec<Vec3>,
    coordinates: Vec<[f64; 2]>,
    normals: Vec<Vec3>,
    /// Materials of the libraries, by name.
    library: HashMap<String, MeshMaterial>,
    /// Index in the mesh of each material in use.
    used: HashMap<String, usize>,
    current: Option<usize>,
    /// Number of polygons that cross themselves.
    crossed: usize,
}

impl ObjReader<'_> {
    fn fault(&self, line: usize, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, line, message)
    }

    fn line(&mut self, number: usize, line: &str) -> Result<(), FileFault> {
        let line = line.split('#').next().unwrap_or("").trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "v" => {
                let [x, y, z] = self.numbers(number, rest, 3)?;
                self.positions.push(vec3(x, y, z));
            }
            "vt" => {
                let [u, v, _] = self.numbers(number, rest, 1)?;
                // OBJ's v runs up, a texture's down.
                self.coordinates.push([u, 1.0 - v]);
            }
            // A normal that is none leaves its corner flat.
            "vn" => self.normals.push(match self.numbers(number, rest, 3) {
                Ok([x, y, z]) => vec3(x, y, z),
                Err(_) => Vec3::ZERO,
            }),
            "f" => self.face(number, rest)?,
            "usemtl" => self.current = Some(self.material(rest)),
            "mtllib" => self.libraries(number, rest)?,
            _ => {}
        }
        Ok(())
    }

    /// Three numbers of which the first `wanted` are required; absent ones are zero.
    fn numbers(&self, line: usize, text: &str, wanted: usize) -> Result<[f64; 3], FileFault> {
        let mut out = [0.0; 3];
        let mut count = 0;
        for (slot, word) in out.iter_mut().zip(text.split_whitespace()) {
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() => *slot = x,
                _ => return Err(self.fault(line, format!("'{word}' is not a finite number; mend this line"))),
            }
            count += 1;
        }
        if count < wanted {
            return Err(
                self.fault(line, format!("this line has {count} of {wanted} numbers; mend this line"))
            );
        }
        Ok(out)
    }

    /// The index of the material of this name; it is added on first use.
    fn material(&mut self, name: &str) -> usize {
        let name = if name.is_empty() { "default" } else { name };
        if let Some(i) = self.used.get(name) {
            return *i;
        }
        let known = self.library.get(name).cloned();
        let missing_warning = (known.is_none() && name != "default").then(|| {
            format!("{}: material '{name}' is in no library; it gets the default reflectance", self.file)
        });
        let material = known.unwrap_or_else(|| MeshMaterial { missing_warning, ..MeshMaterial::named(name) });
        self.mesh.materials.push(material);
        let index = self.mesh.materials.len() - 1;
        self.used.insert(name.to_string(), index);
        index
    }

    /// Reads the libraries of an `mtllib` line.
    fn libraries(&mut self, number: usize, rest: &str) -> Result<(), FileFault> {
        // One name, possibly with spaces, or several.
        let names: Vec<&str> = if self.files.contains(&self.folder.join(rest)) {
            vec![rest]
        } else {
            rest.split_whitespace().collect()
        };
        for name in names {
            let path = self.folder.join(name);
            if !self.files.contains(&path) {
                self.mesh
                    .notes
                    .push(format!("{}:{number}: there is no material library '{name}'", self.file));
                continue;
            }
            for m in mtl::read_library(self.files, &path, &mut self.mesh.notes)? {
                self.library.insert(m.name.clone(), m);
            }
        }
        Ok(())
    }

    /// Adds the polygon of an `f` line.
    fn face(&mut self, number: usize, rest: &str) -> Result<(), FileFault> {
        let (mut corners, mut normals): (Vec<PolygonCorner>, Vec<Vec3>) = Default::default();
        for word in rest.split_whitespace() {
            let mut parts = word.split('/');
            let position = parts.next().unwrap_or("");
            let p = self.lookup(number, position, "vertex", &self.positions)?;
            let uv = match parts.next() {
                None | Some("") => [0.0; 2],
                Some(t) => self.lookup(number, t, "texture coordinate", &self.coordinates)?,
            };
            corners.push((p, uv));
            if let Some(n) = parts.next().filter(|n| !n.is_empty()) {
                normals.push(self.lookup(number, n, "normal", &self.normals).unwrap_or(Vec3::ZERO));
            }
            if corners.len() > MAX_POLYGON_CORNERS {
                return Err(self.fault(
                    number,
                    format!("this face has more than {MAX_POLYGON_CORNERS} corners; triangulate the mesh"),
                ));
            }
        }
        if corners.len() < 3 {
            return Err(self.fault(
                number,
                format!("a face needs at least three corners, not {}; mend or remove it", corners.len()),
            ));
        }
        let material = match self.current {
            Some(m) => m,
            None => self.material("default"),
        };
        self.current = Some(material);
        let template = MeshFace::template(material, self.mesh.face_count);
        self.mesh.face_count += 1;
        if !push_smooth_polygon(&mut self.mesh, &template, &corners, &normals) {
            self.crossed += 1;
        }
        Ok(())
    }

    /// The element at an OBJ index: from 1, or negative from the end.
    fn lookup<T: Copy>(&self, line: usize, word: &str, noun: &str, list: &[T]) -> Result<T, FileFault> {
        let bad = |why: String| self.fault(line, why);
        let index: i64 =
            word.parse().map_err(|_| bad(format!("'{word}' is not a {noun} index; give a whole number")))?;
        if index == 0 {
            return Err(bad(format!("a {noun} index is 0; OBJ counts from 1")));
        }
        let place = if index > 0 { index - 1 } else { list.len() as i64 + index };
        usize::try_from(place).ok().and_then(|i| list.get(i)).copied().ok_or_else(|| {
            bad(format!(
                "{noun} index {index} is out of range: {} are defined above; mend the index",
                list.len()
            ))
        })
    }
}
