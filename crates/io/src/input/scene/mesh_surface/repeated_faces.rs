//! Repeated faces of a mesh: the second of two faces with the same corners in the same order is dropped.
//!
//! A repeated face takes its radiation twice, and its edges belong to three or four faces, so that a closed room would count as an open sheet. Faces
//! of omitted materials do not count; panes, regions and opaque faces are compared among themselves.

use crate::input::mesh::model::{MeshData, MeshFace};
use crate::input::scene::scene_reader::SceneReader;
use std::collections::BTreeSet;
use zonal_scene::topology::{FaceCopy, copies};
use zonal_scene::{Diagnostic, Plate};

/// Faces dropped from a mesh.
#[derive(Default)]
struct Dropped {
    /// Those whose earlier face has the same material, and the first pair.
    same: (usize, Option<[usize; 2]>),
    /// Those whose earlier face has another material, and the first pair.
    other: (usize, Option<[usize; 2]>),
    /// Pairs of materials with common faces.
    materials: BTreeSet<(usize, usize)>,
}

/// Most pairs of materials that a message lists.
const MAX_LISTED_PAIRS: usize = 3;

/// Drops repeated faces with a note, and with a warning where two materials have one face. `kind_of_material` is `None` for materials that are left out.
pub(crate) fn drop_repeated_faces(
    mesh: &mut MeshData,
    kind_of_material: &[Option<usize>],
    name: &str,
    reader: &mut SceneReader<'_>,
) {
    let used = |f: &MeshFace| kind_of_material[f.material].is_some();
    let faces: Vec<MeshFace> = mesh.faces.iter().filter(|f| used(f)).copied().collect();
    let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
    let numbers: Vec<usize> = faces.iter().map(|f| f.face).collect();
    let kind = |i: usize| kind_of_material[faces[i].material].unwrap_or(usize::MAX);
    let found = copies(&plates, &numbers, &kind);
    let mut material_of_face = vec![0; mesh.face_count];
    faces.iter().for_each(|f| material_of_face[f.face] = f.material);
    let mut repeated = vec![false; mesh.face_count];
    let mut dropped = Dropped::default();
    for (f, copy) in faces.iter().zip(&found) {
        let Some(FaceCopy::Repeated(first)) = *copy else { continue };
        if std::mem::replace(&mut repeated[f.face], true) {
            continue;
        }
        let of_first = material_of_face[first];
        let list = if of_first == f.material { &mut dropped.same } else { &mut dropped.other };
        list.0 += 1;
        list.1.get_or_insert([first + 1, f.face + 1]);
        if of_first != f.material {
            dropped.materials.insert((of_first, f.material));
        }
    }
    if dropped.same.0 + dropped.other.0 == 0 {
        return;
    }
    mesh.faces.retain(|f| !(used(f) && repeated[f.face]));
    dropped.report(mesh, name, reader);
}

/// Faces of a surface whose two sides exchange, without those that are the other side of an earlier one: each pair is one sheet.
pub(crate) fn without_opposite_faces<'f>(
    faces: Vec<&'f MeshFace>,
    name: &str,
    reader: &mut SceneReader<'_>,
) -> Vec<&'f MeshFace> {
    let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
    let numbers: Vec<usize> = faces.iter().map(|f| f.face).collect();
    let found = copies(&plates, &numbers, &|_| 0);
    let mut dropped = BTreeSet::new();
    for (f, copy) in faces.iter().zip(&found) {
        if let Some(FaceCopy::Opposite(_)) = copy {
            dropped.insert(f.face);
        }
    }
    if dropped.is_empty() {
        return faces;
    }
    let text = format!(
        "{} face(s) are the other side of an earlier one; both sides of each exchange, so that a pair counts as one sheet",
        dropped.len()
    );
    reader.note(Diagnostic::note("opposite-faces", text).at(format!("surface '{name}'")));
    faces.into_iter().filter(|f| !dropped.contains(&f.face)).collect()
}

impl Dropped {
    fn report(&self, mesh: &MeshData, name: &str, reader: &mut SceneReader<'_>) {
        let place = format!("mesh of '{name}'");
        if let (n, Some([first, second])) = self.same {
            let text = format!(
                "{n} repeated face(s) were dropped (first: face {second} has the corners of face {first}); remove them from the file"
            );
            reader.note(Diagnostic::note("repeated-faces", text).at(place.clone()));
        }
        if let (n, Some([first, second])) = self.other {
            let named = |m: usize| format!("'{}'", mesh.materials[m].name);
            let pairs = self.materials.iter().take(MAX_LISTED_PAIRS);
            let pairs: Vec<String> =
                pairs.map(|(a, b)| format!("{} over {}", named(*b), named(*a))).collect();
            let text = format!(
                "{n} face(s) have the corners of a face of another material and were dropped: {} (first: face {second} over face {first}); remove one of each pair, or write materials.NAME.omit = true",
                pairs.join(", ")
            );
            reader.note(Diagnostic::warning("repeated-faces", text).at(place));
        }
    }
}
