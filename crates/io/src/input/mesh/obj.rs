//! Wavefront OBJ: positions, texture coordinates, polygons, materials.

use super::polygon::{self, Corner};
use super::{Face, Material, Mesh, mtl};
use crate::input::error::Fault;
use crate::input::files::Files;
use std::collections::HashMap;
use std::path::Path;
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;

/// The most corners of one polygon: cutting ears takes the square of them.
const MAX_CORNERS: usize = 1024;

/// Reads an OBJ file's text; material libraries and pictures are looked for beside `path`.
pub(crate) fn parse(files: Files<'_>, path: &Path, file: &str, text: &str) -> Result<Mesh, Fault> {
    let mut reader = Reader {
        files,
        file,
        folder: path.parent().unwrap_or(Path::new("")),
        mesh: Mesh::default(),
        positions: Vec::new(),
        coordinates: Vec::new(),
        library: HashMap::new(),
        used: HashMap::new(),
        current: None,
        crossed: 0,
    };
    let mut pending = String::new();
    for (number, line) in text.lines().enumerate() {
        // A backslash at the end joins the next line.
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
        return Err(Fault::new(file, "", "this mesh has no faces; export it again"));
    }
    if reader.crossed > 0 {
        let n = reader.crossed;
        reader.mesh.notes.push(format!("{file}: {n} polygons cross themselves and were cut as fans"));
    }
    Ok(reader.mesh)
}

struct Reader<'a> {
    files: Files<'a>,
    file: &'a str,
    folder: &'a Path,
    mesh: Mesh,
    positions: Vec<Vec3>,
    coordinates: Vec<[f64; 2]>,
    /// Materials of the libraries, by name, and the places of those in use.
    library: HashMap<String, Material>,
    used: HashMap<String, usize>,
    current: Option<usize>,
    crossed: usize,
}

impl Reader<'_> {
    fn fault(&self, line: usize, what: impl std::fmt::Display) -> Fault {
        Fault::new(self.file, line, what)
    }

    fn line(&mut self, number: usize, line: &str) -> Result<(), Fault> {
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
            "f" => self.face(number, rest)?,
            "usemtl" => self.current = Some(self.material(rest)),
            "mtllib" => self.libraries(number, rest)?,
            _ => {}
        }
        Ok(())
    }

    /// At least `wanted` numbers; those left out are zero.
    fn numbers(&self, line: usize, text: &str, wanted: usize) -> Result<[f64; 3], Fault> {
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

    fn material(&mut self, name: &str) -> usize {
        let name = if name.is_empty() { "default" } else { name };
        if let Some(i) = self.used.get(name) {
            return *i;
        }
        let known = self.library.get(name).cloned();
        let unknown = (known.is_none() && name != "default").then(|| {
            format!("{}: material '{name}' is in no library; it gets the default reflectance", self.file)
        });
        let material = known.unwrap_or_else(|| Material { unknown, ..Material::named(name) });
        self.mesh.materials.push(material);
        let index = self.mesh.materials.len() - 1;
        self.used.insert(name.to_string(), index);
        index
    }

    fn libraries(&mut self, number: usize, rest: &str) -> Result<(), Fault> {
        // One name, possibly with spaces, or several.
        let names: Vec<&str> = if self.files.has(&self.folder.join(rest)) {
            vec![rest]
        } else {
            rest.split_whitespace().collect()
        };
        for name in names {
            let path = self.folder.join(name);
            if !self.files.has(&path) {
                self.mesh
                    .notes
                    .push(format!("{}:{number}: there is no material library '{name}'", self.file));
                continue;
            }
            for m in mtl::read(self.files, &path, &mut self.mesh.notes)? {
                self.library.insert(m.name.clone(), m);
            }
        }
        Ok(())
    }

    fn face(&mut self, number: usize, rest: &str) -> Result<(), Fault> {
        let mut corners: Vec<Corner> = Vec::new();
        for word in rest.split_whitespace() {
            let mut parts = word.split('/');
            let position = parts.next().unwrap_or("");
            let p = self.lookup(number, position, "vertex", &self.positions)?;
            let uv = match parts.next() {
                None | Some("") => [0.0; 2],
                Some(t) => self.lookup(number, t, "texture coordinate", &self.coordinates)?,
            };
            corners.push((p, uv));
            if corners.len() > MAX_CORNERS {
                return Err(self.fault(
                    number,
                    format!("this face has more than {MAX_CORNERS} corners; triangulate the mesh"),
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
        let template = Face {
            material,
            plate: Plate::triangle(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO),
            uv: [[0.0; 2]; 3],
            scale: 1.0,
        };
        if !polygon::push(&mut self.mesh.faces, &template, &corners) {
            self.crossed += 1;
        }
        Ok(())
    }

    /// Looks an index up: from 1, or negative from the end.
    fn lookup<T: Copy>(&self, line: usize, word: &str, what: &str, list: &[T]) -> Result<T, Fault> {
        let bad = |why: String| self.fault(line, why);
        let index: i64 =
            word.parse().map_err(|_| bad(format!("'{word}' is not a {what} index; give a whole number")))?;
        if index == 0 {
            return Err(bad(format!("a {what} index is 0; OBJ counts from 1")));
        }
        let place = if index > 0 { index - 1 } else { list.len() as i64 + index };
        usize::try_from(place).ok().and_then(|i| list.get(i)).copied().ok_or_else(|| {
            bad(format!(
                "{what} index {index} is out of range: {} are defined above; mend the index",
                list.len()
            ))
        })
    }
}
