//! View3D's files, as far as the tests need them: enclosures (.vs3), printed matrices.

#[path = "../../../reference/tests/support/view3d_files.rs"]
mod view3d_files;

pub(crate) use view3d_files::text;
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Vec3;

/// A surface of a file, as written.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// Corners, in the file's order and unit.
    pub corners: Vec<Vec3>,
    /// Number (from one) of the surface that this one is a part of and is taken away from; zero for none.
    pub base: usize,
    /// Number (from one) of the surface that this one's factors are added to; zero for none.
    pub combine: usize,
}

/// Vertices and surfaces of an enclosure; v4 = 0: a triangle.
pub(crate) fn surfaces(text: &str) -> Vec<Surface> {
    let (mut vertices, mut out) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split('!').next().unwrap_or("").split_whitespace().collect();
        let number = |k: usize| words[k].parse::<f64>().unwrap();
        match words.first().map(|w| w.to_lowercase()).as_deref() {
            Some("v") => vertices.push(Vec3 { x: number(2), y: number(3), z: number(4) }),
            Some("s") => {
                let at = |k: usize| words[k].parse::<usize>().unwrap();
                let list = (2..6).map(at).filter(|v| *v > 0).map(|v| vertices[v - 1]).collect();
                out.push(Surface { corners: list, base: at(6), combine: at(7) });
            }
            Some("end") => break,
            _ => {}
        }
    }
    out
}

/// A surface as convex polygons: itself, or its two triangles along the diagonal that lies inside.
pub(crate) fn polygons(s: &Surface) -> Vec<ConvexPolygon> {
    let c = &s.corners;
    if let Some(p) = ConvexPolygon::new(c.clone()) {
        return vec![p];
    }
    let split = |k: usize| {
        let part = |i: usize, j: usize| ConvexPolygon::new(vec![c[k % 4], c[(k + i) % 4], c[(k + j) % 4]]);
        Some(vec![part(1, 2)?, part(2, 3)?])
    };
    let same_side = |p: &Vec<ConvexPolygon>| p[0].normal().dot(p[1].normal()) > 0.0;
    (0..2).filter_map(split).find(same_side).expect("a quadrangle that two triangles make")
}

/// Exchange areas A_i F_ij of all surfaces behind one another, bases without their parts, and each row's area; `factors` gives the factors of polygons.
pub(crate) fn exchange_areas(
    all: &[Surface],
    factors: impl Fn(&[ConvexPolygon]) -> Vec<Vec<f64>>,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let parts: Vec<Vec<ConvexPolygon>> = all.iter().map(polygons).collect();
    let walls: Vec<ConvexPolygon> = parts.iter().flatten().cloned().collect();
    let of_wall: Vec<usize> = parts.iter().enumerate().flat_map(|(i, p)| p.iter().map(move |_| i)).collect();
    let n = all.len();
    let mut f = vec![vec![0.0; n]; n];
    for (a, row) in factors(&walls).iter().enumerate() {
        row.iter().enumerate().for_each(|(b, x)| f[of_wall[a]][of_wall[b]] += x * walls[a].area());
    }
    let mut areas: Vec<f64> = parts.iter().map(|p| p.iter().map(ConvexPolygon::area).sum()).collect();
    for i in (0..n).filter(|i| all[*i].base > 0) {
        let base = all[i].base - 1;
        areas[base] -= areas[i];
        let part = f[i].clone();
        f[base].iter_mut().zip(&part).for_each(|(x, p)| *x -= p);
        f.iter_mut().zip(&part).for_each(|(row, p)| row[base] -= p);
    }
    (areas, f)
}

/// The surface that each one's factors are added to in the end, numbered among those.
pub(crate) fn groups(all: &[Surface]) -> Vec<usize> {
    let kept: Vec<usize> = (0..all.len()).filter(|i| all[*i].combine == 0).collect();
    let root = |mut i: usize| {
        while all[i].combine > 0 {
            i = all[i].combine - 1;
        }
        kept.iter().position(|k| *k == i).unwrap()
    };
    (0..all.len()).map(root).collect()
}

/// Areas and plain factors F_ij of the combined surfaces.
pub(crate) fn combined(all: &[Surface], (areas, f): &(Vec<f64>, Vec<Vec<f64>>)) -> (Vec<f64>, Vec<Vec<f64>>) {
    let group = groups(all);
    let n = group.iter().max().unwrap() + 1;
    let (mut a, mut sums) = (vec![0.0; n], vec![vec![0.0; n]; n]);
    for i in 0..all.len() {
        a[group[i]] += areas[i];
        (0..all.len()).for_each(|j| sums[group[i]][group[j]] += f[i][j]);
    }
    for (row, a) in sums.iter_mut().zip(&a) {
        row.iter_mut().for_each(|x| *x /= a);
    }
    (a, sums)
}

/// X of M X = R by Gauss's elimination.
fn solved(mut m: Vec<Vec<f64>>, mut r: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = m.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| m[*i][k].abs().total_cmp(&m[*j][k].abs())).unwrap();
        m.swap(k, pivot);
        r.swap(k, pivot);
        for i in (0..n).filter(|i| *i != k) {
            let f = m[i][k] / m[k][k];
            for j in 0..n {
                m[i][j] -= f * m[k][j];
                r[i][j] -= f * r[k][j];
            }
        }
    }
    for k in 0..n {
        let d = m[k][k];
        r[k].iter_mut().for_each(|x| *x /= d);
    }
    r
}

/// Plain factors F from total exchange factors, G = ε² F + (1 − ε) G F.
pub(crate) fn plain(g: &[Vec<f64>], e: f64) -> Vec<Vec<f64>> {
    let mut m: Vec<Vec<f64>> = g.iter().map(|r| r.iter().map(|x| x * (1.0 - e)).collect()).collect();
    m.iter_mut().enumerate().for_each(|(i, r)| r[i] += e * e);
    solved(m, g.to_vec())
}

/// Total exchange factors G = ε² (I − (1 − ε) F)⁻¹ F of plain ones.
pub(crate) fn grey(f: &[Vec<f64>], e: f64) -> Vec<Vec<f64>> {
    let mut m: Vec<Vec<f64>> = f.iter().map(|r| r.iter().map(|x| x * (e - 1.0)).collect()).collect();
    m.iter_mut().enumerate().for_each(|(i, r)| r[i] += 1.0);
    solved(m, f.iter().map(|r| r.iter().map(|x| x * e * e).collect()).collect())
}

/// ε of every surface of every printed result.
pub(crate) const EMISSIVITY: f64 = 0.9;

/// Areas and matrix of a printed 3-D result.
pub(crate) struct Printed {
    /// Areas.
    pub areas: Vec<f64>,
    /// The matrix, row by row.
    pub matrix: Vec<Vec<f64>>,
}

/// Reads a printed 3-D result.
pub(crate) fn printed(text: &str) -> Printed {
    let row = |l: &str| l.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<f64>>();
    let mut rows: Vec<Vec<f64>> = text.lines().skip(1).filter(|l| !l.trim().is_empty()).map(row).collect();
    let (areas, emissivities) = (rows.remove(0), rows.pop().unwrap());
    assert!(emissivities.iter().all(|e| *e == EMISSIVITY));
    Printed { areas, matrix: rows }
}

/// A_i G_ij with i ≥ j from a file that lists its triangle, a line of number, area, emissivity and name before each row.
pub(crate) fn triangle(text: &str) -> Vec<Vec<f64>> {
    let text = text.replace('\u{2011}', "-");
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip_while(|l| !l.starts_with("!  #")).skip(1) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.first().is_some_and(|w| w.parse::<usize>().is_ok()) {
            rows.push(Vec::new());
        } else if let Some(row) = rows.last_mut() {
            row.extend(words.iter().map(|w| w.parse::<f64>().unwrap()));
        }
    }
    rows
}
