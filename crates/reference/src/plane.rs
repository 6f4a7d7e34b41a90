//! View factors of walls in the plane (long ducts seen in cross-section), one behind the other: exact to rounding.
//!
//! F_ij L_i = ½ ∫ Σ (sin φ_Q − sin φ_P) dx over wall i, the sum over the intervals of directions [φ_P, φ_Q] in which x sees wall j, φ from
//! i's normal. The ends of an interval are ends of walls. Which ends they are changes only where x lies on the line through two
//! ends; between two such points one look from the middle settles the order, and
//! ∫ sin φ_P dx = |x_1 − P| − |x_2 − P| is elementary: Hottel's crossed strings, one stretch of wall at a time.

/// A wall from (x, y) to (x, y); its front is to the left.
pub type Wall = [[f64; 2]; 2];

type Point = [f64; 2];

/// Relative size of what counts as nothing.
const TRIFLE: f64 = 1e-12;

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}
fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
fn distance(a: Point, b: Point) -> f64 {
    let d = minus(a, b);
    d[0].hypot(d[1])
}

/// F_ij for all walls, row by row: the share of what leaves the front of i that arrives at the front of j.
pub fn view_factors(walls: &[Wall]) -> Vec<Vec<f64>> {
    let mut ends: Vec<Point> = walls.iter().flatten().copied().collect();
    ends.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    ends.dedup();
    (0..walls.len()).map(|i| row(walls, &ends, i)).collect()
}

fn row(walls: &[Wall], ends: &[Point], i: usize) -> Vec<f64> {
    let [from, to] = walls[i];
    let length = distance(from, to);
    let at = |t: f64| [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t];
    let mut out = vec![0.0; walls.len()];
    let cuts = changes(walls[i], ends);
    for w in cuts.windows(2).filter(|w| w[1] - w[0] > TRIFLE) {
        look(walls, ends, i, at(w[0]), at(w[1]), &mut out);
    }
    out.iter_mut().for_each(|f| *f /= 2.0 * length);
    out
}

/// Where the wall is crossed by the line through two ends: parameters from 0 to 1, ascending.
fn changes([from, to]: Wall, ends: &[Point]) -> Vec<f64> {
    let d = minus(to, from);
    let mut cuts = vec![0.0, 1.0];
    for (k, p) in ends.iter().enumerate() {
        for q in &ends[..k] {
            let e = minus(*q, *p);
            let bottom = cross(d, e);
            if bottom.abs() > TRIFLE * (dot(d, d) * dot(e, e)).sqrt() {
                let t = cross(minus(*p, from), e) / bottom;
                if t > 0.0 && t < 1.0 {
                    cuts.push(t);
                }
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Adds what the stretch from a to b of wall i sees.
fn look(walls: &[Wall], ends: &[Point], i: usize, a: Point, b: Point, out: &mut [f64]) {
    let along = minus(walls[i][1], walls[i][0]);
    let length = dot(along, along).sqrt();
    let along = [along[0] / length, along[1] / length];
    let normal = [-along[1], along[0]];
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let step = distance(a, b);
    // (sin φ at the middle, ∫ sin φ dx)
    let mut rays = vec![(-1.0, -step), (1.0, step)];
    for p in ends {
        let v = minus(*p, middle);
        if dot(v, normal) > TRIFLE * length {
            rays.push((dot(v, along) / dot(v, v).sqrt(), distance(a, *p) - distance(b, *p)));
        }
    }
    rays.sort_by(|x, y| x.0.total_cmp(&y.0));
    for w in rays.windows(2).filter(|w| w[1].0 - w[0].0 > TRIFLE) {
        let s = 0.5 * (w[0].0 + w[1].0);
        let c = (1.0 - s * s).sqrt();
        let ray = [s * along[0] + c * normal[0], s * along[1] + c * normal[1]];
        if let Some(j) = first(walls, i, middle, ray) {
            out[j] += w[1].1 - w[0].1;
        }
    }
}

/// The wall whose front is the first thing on a ray; of two at one place the one that faces it.
fn first(walls: &[Wall], i: usize, x: Point, ray: Point) -> Option<usize> {
    let mut best: Option<(f64, usize, bool)> = None;
    for (j, [p, q]) in walls.iter().enumerate() {
        let (e, v) = (minus(*q, *p), minus(*p, x));
        let (sp, sq) = (cross(ray, v), cross(ray, minus(*q, x)));
        if j == i || (sp > 0.0) == (sq > 0.0) {
            continue;
        }
        let bottom = cross(ray, e);
        let t = cross(v, e) / bottom;
        // The front is to the left of e: the ray comes from there if it turns clockwise to e.
        let front = bottom > 0.0;
        if t > TRIFLE
            && best.is_none_or(|(s, _, f)| t < s * (1.0 - TRIFLE) || (t < s * (1.0 + TRIFLE) && front && !f))
        {
            best = Some((t, j, front));
        }
    }
    best.filter(|b| b.2).map(|b| b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_duct_and_one_with_a_plate_in_it() {
        let square = [
            [[0.0, 0.0], [1.0, 0.0]],
            [[1.0, 0.0], [1.0, 1.0]],
            [[1.0, 1.0], [0.0, 1.0]],
            [[0.0, 1.0], [0.0, 0.0]],
        ];
        let f = view_factors(&square);
        assert!((f[0][2] - (2f64.sqrt() - 1.0)).abs() < 1e-15);
        assert!((f[0][1] - (1.0 - 0.5 * 2f64.sqrt())).abs() < 1e-15);
        // A plate across the middle, its two faces one wall each: floor and ceiling see each other past it on both sides.
        let mut duct = square.to_vec();
        duct.push([[0.25, 0.5], [0.75, 0.5]]);
        duct.push([[0.75, 0.5], [0.25, 0.5]]);
        let f = view_factors(&duct);
        for r in &f {
            assert!((r.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
        // Crossed strings from the floor to the plate: diagonals minus sides.
        let want = (0.75f64.hypot(0.5) * 2.0 - 0.25f64.hypot(0.5) * 2.0) / 2.0;
        assert!((f[0][5] - want).abs() < 1e-15);
        assert_eq!(f[0][4], 0.0);
        // Past the plate's left end P: crossed strings |OP| + |P(1,1)| twice, uncrossed 1 and 2 |P(1,1)|; the right end the same.
        let want = 2.0 * 0.25f64.hypot(0.5) - 1.0;
        assert!((f[0][2] - want).abs() < 1e-15);
    }
}
