//! The facets of an STL file, and their collection while it is read.

use crate::input::reading::error::FileFault;
use std::collections::HashMap;
use zonal_math::Vec3;

/// Smallest area of a facet relative to the square of its longest edge.
const MIN_RELATIVE_FACET_AREA: f64 = 1e-14;
/// Name of facets without one.
pub(super) const UNNAMED_PART: &str = "default";

/// The facets of an STL file, in its unit and axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StlFile {
    /// Names of the parts, each once, in the order of the file; `default` where the file has none.
    pub parts: Vec<String>,
    /// The facets with an area.
    pub facets: Vec<StlFacet>,
    /// Number of facets in the file, those without area included.
    pub facet_count: usize,
    /// Repairs: facets that were dropped, normals that oppose the order of the corners.
    pub notes: Vec<String>,
}

/// A triangle of an STL file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StlFacet {
    /// Counter-clockwise from the front.
    pub corners: [Vec3; 3],
    /// Index of its part.
    pub part: usize,
    /// Its number in the file, from 0.
    pub number: usize,
}

/// A file while it is read.
#[derive(Default)]
pub(super) struct StlBuilder {
    stl: StlFile,
    /// Index of each part by its name.
    part_of_name: HashMap<String, usize>,
    /// Facets whose normal opposes the order of their corners.
    opposed: usize,
}

impl StlBuilder {
    /// The index of the part of this name.
    pub(super) fn part(&mut self, name: &str) -> usize {
        let name = if name.is_empty() { UNNAMED_PART } else { name };
        if let Some(part) = self.part_of_name.get(name) {
            return *part;
        }
        let part = self.stl.parts.len();
        self.stl.parts.push(name.to_string());
        self.part_of_name.insert(name.to_string(), part);
        part
    }

    /// Adds a facet of finite corners, unless it has no area. The normal may be zero or not a number.
    pub(super) fn push(&mut self, part: usize, normal: Vec3, corners: [Vec3; 3]) {
        let number = self.stl.facet_count;
        self.stl.facet_count += 1;
        let [a, b, c] = corners;
        let twice_area = (b - a).cross(c - a);
        let longest = (b - a).length2().max((c - a).length2()).max((c - b).length2());
        if 0.5 * twice_area.length() <= MIN_RELATIVE_FACET_AREA * longest {
            return;
        }
        self.opposed += usize::from(normal.dot(twice_area) < 0.0);
        self.stl.facets.push(StlFacet { corners, part, number });
    }

    /// Adds a note of the file.
    pub(super) fn note(&mut self, text: String) {
        self.stl.notes.push(text);
    }

    pub(super) fn finish(mut self, file: &str) -> Result<StlFile, FileFault> {
        let count = self.stl.facet_count;
        let dropped = count - self.stl.facets.len();
        let fault = |message: String| Err(FileFault::new(file, "", message));
        match (count, dropped) {
            (0, _) => return fault("this mesh has no facets; export it again".into()),
            (n, d) if n == d => {
                return fault(format!("all {n} faces are without area; export the mesh again"));
            }
            (_, 0) => {}
            (_, d) => self.stl.notes.push(format!("{file}: {d} facets without area were dropped")),
        }
        if self.opposed > 0 {
            let n = self.opposed;
            self.stl.notes.push(format!(
                "{file}: the normals of {n} facets oppose the order of their corners; the corners decide which side is the front"
            ));
        }
        Ok(self.stl)
    }
}
