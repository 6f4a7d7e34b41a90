//! Exchange areas of infinitely long strips: crossed strings with obstructions, exact to rounding.
//!
//! In a vacuum that repeats along an axis, walls of which every one extends along the whole axis are segments of its cross-section. The exchange of a
//! length L of wall i with all of wall j is
//!
//! ```text
//!     F_ij = L/2 ∫_i Σ (sin φ_Q − sin φ_P) dx
//! ```
//!
//! over the intervals [φ_P, φ_Q] of directions, measured from the normal of i, in which x sees j. P and Q are ends of j or of walls between. With x
//! the coordinate along i, ∫ sin φ_P dx from x₁ to x₂ is |x₁ − P| − |x₂ − P|: Hottel's crossed strings, one stretch of i at a time. Intervals change
//! only where x lies on a line through two ends. Without walls between, one stretch gives
//!
//! ```text
//!     F_ij = L/2 [ (|i₀ − j₀| + |i₁ − j₁|) − (|i₀ − j₁| + |i₁ − j₀|) ].
//! ```
//!
//! Source: Hottel and Sarofim, Radiative Transfer (1967), section 2-5. Both walls are clipped to the half-planes before their fronts first.
//! Cost: a constant, and e² log e for e ends of walls between.

/// A point of the cross-section, m.
type Point = [f64; 2];

/// A wall of the cross-section from one point to another; its front is to the left.
pub(crate) type Segment = [Point; 2];

/// Relative size below which lengths and angles count as zero.
const RELATIVE_TOLERANCE: f64 = 1e-11;

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
fn between([p, q]: Segment, t: f64) -> Point {
    [p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t]
}

/// The part of `s` on the left of the line through `of`; `None` if there is none. Ends within `slack` of the line lie on it.
fn clipped(s: Segment, of: Segment, slack: f64) -> Option<Segment> {
    let d = minus(of[1], of[0]);
    let height = |p: Point| {
        let h = cross(d, minus(p, of[0])) / d[0].hypot(d[1]);
        if h.abs() <= slack { 0.0 } else { h }
    };
    let (a, b) = (height(s[0]), height(s[1]));
    if a <= 0.0 && b <= 0.0 {
        None
    } else if a < 0.0 {
        Some([between(s, a / (a - b)), s[1]])
    } else if b < 0.0 {
        Some([s[0], between(s, a / (a - b))])
    } else {
        Some(s)
    }
}

/// Exchange area per length (m²/m) of two segments among others that obstruct with both sides. The second value is true if some segment stands between.
pub(crate) fn exchange_per_length(a: Segment, b: Segment, walls: &[Segment]) -> (f64, bool) {
    let size = [a, b].iter().flatten().fold(0.0f64, |m, p| m.max(distance(*p, a[0])));
    let slack = RELATIVE_TOLERANCE * size;
    let (Some(a), Some(b)) = (clipped(a, b, slack), clipped(b, a, slack)) else { return (0.0, false) };
    let hull = [[a[0], a[1]], [a[1], b[0]], [b[0], b[1]], [b[1], a[0]]];
    let inside = |wall: &&Segment| {
        let sides = hull.iter().filter(|s| distance(s[0], s[1]) > slack);
        let part = { sides }.try_fold(**wall, |s, side| clipped(s, *side, slack));
        part.is_some_and(|[p, q]| distance(p, q) > slack)
    };
    let obstacles: Vec<Segment> = walls.iter().filter(inside).copied().collect();
    if obstacles.is_empty() {
        let f = distance(a[0], b[0]) + distance(a[1], b[1]) - distance(a[0], b[1]) - distance(a[1], b[0]);
        return (0.5 * f.max(0.0), false);
    }
    (visible_exchange(a, b, &obstacles), true)
}

/// The exchange of two segments that face each other, with obstacles between.
fn visible_exchange(a: Segment, b: Segment, obstacles: &[Segment]) -> f64 {
    let ends = ends_of(b, obstacles);
    let cuts = breakpoints(a, &ends);
    let stretches = cuts.windows(2).filter(|w| w[1] - w[0] > RELATIVE_TOLERANCE);
    0.5 * stretches.map(|w| stretch([between(a, w[0]), between(a, w[1])], b, &ends, obstacles)).sum::<f64>()
}

/// The ends of `b` and of the obstacles, and the points at which these cross each other.
fn ends_of(b: Segment, obstacles: &[Segment]) -> Vec<Point> {
    let mut all: Vec<Segment> = obstacles.to_vec();
    all.push(b);
    let mut ends: Vec<Point> = all.iter().flatten().copied().collect();
    for (k, s) in all.iter().enumerate() {
        for other in &all[..k] {
            let (d, e, v) = (minus(s[1], s[0]), minus(other[1], other[0]), minus(other[0], s[0]));
            let denominator = cross(d, e);
            let (t, u) = (cross(v, e) / denominator, cross(v, d) / denominator);
            if t > 0.0 && t < 1.0 && u > 0.0 && u < 1.0 {
                ends.push(between(*s, t));
            }
        }
    }
    ends.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    ends.dedup();
    ends
}

/// Parameters from 0 to 1, ascending, at which the line through two ends crosses a segment.
fn breakpoints(a: Segment, ends: &[Point]) -> Vec<f64> {
    let d = minus(a[1], a[0]);
    let mut cuts = vec![0.0, 1.0];
    for (k, p) in ends.iter().enumerate() {
        for q in &ends[..k] {
            let e = minus(*q, *p);
            let denominator = cross(d, e);
            if denominator.abs() > RELATIVE_TOLERANCE * (dot(d, d) * dot(e, e)).sqrt() {
                let t = cross(minus(*p, a[0]), e) / denominator;
                if t > 0.0 && t < 1.0 {
                    cuts.push(t);
                }
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// ∫ Σ (sin φ_Q − sin φ_P) dx over a stretch of the first segment that no line through two ends crosses.
fn stretch([x1, x2]: Segment, b: Segment, ends: &[Point], obstacles: &[Segment]) -> f64 {
    let length = distance(x1, x2);
    let along = minus(x2, x1).map(|x| x / length);
    let normal = [-along[1], along[0]];
    let middle = between([x1, x2], 0.5);
    // Sine from the normal, and the integral of the sine, for each end in front and for both directions along the segment.
    let mut rays = vec![(-1.0, -length), (1.0, length)];
    for p in ends {
        let v = minus(*p, middle);
        if dot(v, normal) > RELATIVE_TOLERANCE * length {
            rays.push((dot(v, along) / v[0].hypot(v[1]), distance(x1, *p) - distance(x2, *p)));
        }
    }
    rays.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut sum = 0.0;
    for w in rays.windows(2).filter(|w| w[1].0 - w[0].0 > RELATIVE_TOLERANCE) {
        let s = 0.5 * (w[0].0 + w[1].0);
        let c = (1.0 - s * s).sqrt();
        let ray = [s * along[0] + c * normal[0], s * along[1] + c * normal[1]];
        let Some(reach) = hit(middle, ray, b) else { continue };
        let limit = reach * (1.0 - RELATIVE_TOLERANCE);
        if !obstacles.iter().any(|o| hit(middle, ray, *o).is_some_and(|t| t > 0.0 && t < limit)) {
            sum += w[1].1 - w[0].1;
        }
    }
    sum
}

/// The distance along a ray at which it crosses a segment, negative behind its origin.
fn hit(x: Point, ray: Point, [p, q]: Segment) -> Option<f64> {
    let (v, w) = (minus(p, x), minus(q, x));
    ((cross(ray, v) > 0.0) != (cross(ray, w) > 0.0)).then(|| cross(v, minus(q, p)) / cross(ray, minus(q, p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_reference::crossed_strings::view_factors;

    /// A duct with a bent wall, a two-sided plate and a solid triangle; fronts to the left.
    fn duct() -> Vec<Segment> {
        let ring = |points: &[Point]| -> Vec<Segment> {
            (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]).collect()
        };
        let mut walls = ring(&[[0.0, 0.0], [1.3, 0.0], [1.0, 0.7], [1.3, 1.1], [0.0, 1.0], [-0.2, 0.4]]);
        walls.extend(ring(&[[0.3, 0.2], [0.35, 0.5], [0.55, 0.35]]));
        let plate = [[0.7, 0.3], [0.8, 0.8]];
        walls.extend([plate, [plate[1], plate[0]]]);
        walls
    }

    // Guards (numbers): a duct of infinite length has crossed strings, with obstructions.
    #[test]
    fn obstructed_pairs_equal_the_reference() {
        let walls = duct();
        let want = view_factors(&walls);
        let mut obstructed = 0;
        for i in 0..walls.len() {
            for j in 0..walls.len() {
                let (f, hidden) = exchange_per_length(walls[i], walls[j], &walls);
                obstructed += usize::from(hidden);
                let length = distance(walls[i][0], walls[i][1]);
                assert!((f - length * want[i][j]).abs() < 1e-12, "{i} {j}: {f} {}", length * want[i][j]);
            }
        }
        assert!(obstructed > 10, "{obstructed}");
    }

    #[test]
    fn partition_leaves_two_narrow_ducts() {
        let (floor, ceiling) = ([[0.0, 0.0], [1.0, 0.0]], [[1.0, 1.0], [0.0, 1.0]]);
        let (open, obstructed) = exchange_per_length(floor, ceiling, &[]);
        assert!(!obstructed && (open - (2f64.sqrt() - 1.0)).abs() < 1e-14);
        let (hidden, obstructed) = exchange_per_length(floor, ceiling, &[[[0.5, 0.0], [0.5, 1.0]]]);
        assert!(obstructed && (hidden - 2.0 * (1.25f64.sqrt() - 1.0)).abs() < 1e-13);
    }

    #[test]
    fn rows_of_a_closed_duct_close_and_are_symmetric() {
        let walls = duct();
        let f = |i: usize, j: usize| exchange_per_length(walls[i], walls[j], &walls).0;
        for i in 0..walls.len() {
            let row: f64 = (0..walls.len()).map(|j| f(i, j)).sum();
            assert!((row / distance(walls[i][0], walls[i][1]) - 1.0).abs() < 1e-11, "{i}: {row}");
            assert!((0..i).all(|j| (f(i, j) - f(j, i)).abs() < 1e-12));
        }
    }
}
