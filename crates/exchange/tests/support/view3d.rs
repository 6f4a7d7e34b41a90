//! View3D's files, as far as the tests need them: enclosures (.vs3), cross-sections (.vs2), printed matrices.

use std::path::PathBuf;
use zonal_exchange::polygon::visible::Polygon;
use zonal_math::Vec3;

/// A surface of a file, as written.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Corners, in the file's order and unit.
    pub corners: Vec<Vec3>,
    /// Number (from one) of the surface that this one is a part of and is taken away from; zero for none.
    pub base: usize,
    /// Number (from one) of the surface that this one's factors are added to; zero for none.
    pub combine: usize,
    /// Emissivity.
    pub emissivity: f64,
}

/// The text of a file below View3D's folder, or None with a line on the standard output.
pub fn text(name: &str) -> Option<String> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/thermal-view3d"));
    let path = root.join(name);
    match std::fs::read(&path) {
        Ok(bytes) => Some(String::from_utf8_lossy(&bytes).into_owned()),
        Err(_) => {
            println!("skipped: {} is missing", path.display());
            None
        }
    }
}

/// Vertices and surfaces of an enclosure. `corners` is 4 for .vs3 (v4 = 0: a triangle) and 2 for .vs2.
pub fn surfaces(text: &str, corners: usize) -> Vec<Surface> {
    let (mut vertices, mut out) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split('!').next().unwrap_or("").split_whitespace().collect();
        let number = |k: usize| words[k].parse::<f64>().unwrap();
        match words.first().map(|w| w.to_lowercase()).as_deref() {
            Some("v") => {
                vertices.push(Vec3 { x: number(2), y: number(3), z: words.get(4).map_or(0.0, |_| number(4)) })
            }
            Some("s") => {
                let at = |k: usize| words[k].parse::<usize>().unwrap();
                let list = (2..2 + corners).map(at).filter(|v| *v > 0).map(|v| vertices[v - 1]).collect();
                // A cross-section has a column more, for obstructions.
                let k = if corners == 2 { 5 } else { 6 };
                out.push(Surface {
                    corners: list,
                    base: at(k),
                    combine: at(k + 1),
                    emissivity: number(k + 2),
                });
            }
            Some("end") => break,
            _ => {}
        }
    }
    out
}

/// A surface as convex polygons: itself, or its two triangles along the diagonal that lies inside.
pub fn polygons(s: &Surface) -> Vec<Polygon> {
    let c = &s.corners;
    if let Some(p) = Polygon::new(c.clone()) {
        return vec![p];
    }
    let split = |k: usize| {
        let part = |i: usize, j: usize| Polygon::new(vec![c[k % 4], c[(k + i) % 4], c[(k + j) % 4]]);
        Some(vec![part(1, 2)?, part(2, 3)?])
    };
    let same_side = |p: &Vec<Polygon>| p[0].normal().dot(p[1].normal()) > 0.0;
    (0..2).filter_map(split).find(same_side).expect("a quadrangle that two triangles make")
}

/// Areas, matrix and emissivities of a printed 3-D result.
pub struct Printed {
    /// Areas.
    pub areas: Vec<f64>,
    /// The matrix, row by row.
    pub matrix: Vec<Vec<f64>>,
    /// Emissivities.
    pub emissivities: Vec<f64>,
}

/// Reads a printed 3-D result.
pub fn printed(text: &str) -> Printed {
    let row = |l: &str| l.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<f64>>();
    let mut rows: Vec<Vec<f64>> = text.lines().skip(1).filter(|l| !l.trim().is_empty()).map(row).collect();
    let (areas, emissivities) = (rows.remove(0), rows.pop().unwrap());
    Printed { areas, matrix: rows, emissivities }
}
