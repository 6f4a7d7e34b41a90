//! Convex polygons in a plane: intersection, difference, clipping of segments.

/// A point (x, z).
pub(super) type Point2 = [f64; 2];

/// Twice the signed area of the triangle a, b, p: positive if `p` is to the left of the line from `a` to `b`.
fn orientation(a: Point2, b: Point2, p: Point2) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Twice the signed area of a polygon.
pub(super) fn twice_area(polygon: &[Point2]) -> f64 {
    (0..polygon.len()).map(|i| orientation([0.0; 2], polygon[i], polygon[(i + 1) % polygon.len()])).sum()
}

/// The part to the left of the line from `a` to `b`.
pub(super) fn clip_left_of(polygon: &[Point2], a: Point2, b: Point2) -> Vec<Point2> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for i in 0..polygon.len() {
        let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (dp, dq) = (orientation(a, b, p), orientation(a, b, q));
        if dp >= 0.0 {
            out.push(p);
        }
        if (dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0) {
            let t = dp / (dp - dq);
            out.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    if out.len() < 3 || twice_area(&out).abs() < 1e-6 { Vec::new() } else { out }
}

/// Intersection of two convex polygons, both counter-clockwise.
pub(super) fn intersection(polygon: &[Point2], other: &[Point2]) -> Vec<Point2> {
    let edges = (0..other.len()).map(|i| (other[i], other[(i + 1) % other.len()]));
    edges
        .fold(polygon.to_vec(), |rest, (a, b)| if rest.is_empty() { rest } else { clip_left_of(&rest, a, b) })
}

/// Difference of two convex polygons, in convex pieces.
pub(super) fn difference(polygon: &[Point2], other: &[Point2]) -> Vec<Vec<Point2>> {
    let mut pieces = Vec::new();
    let mut rest = polygon.to_vec();
    for i in 0..other.len() {
        let (a, b) = (other[i], other[(i + 1) % other.len()]);
        let out = clip_left_of(&rest, b, a);
        if !out.is_empty() {
            pieces.push(out);
        }
        rest = clip_left_of(&rest, a, b);
        if rest.is_empty() {
            break;
        }
    }
    pieces
}

/// The part of a piece of a line within a convex polygon.
pub(super) fn clip_segment(polygon: &[Point2], a: Point2, b: Point2) -> Option<(Point2, Point2)> {
    let (mut lo, mut hi) = (0.0f64, 1.0f64);
    for i in 0..polygon.len() {
        let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (da, db) = (orientation(p, q, a), orientation(p, q, b));
        if da < 0.0 && db < 0.0 {
            return None;
        }
        if da < 0.0 {
            lo = lo.max(da / (da - db));
        } else if db < 0.0 {
            hi = hi.min(da / (da - db));
        }
    }
    let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    (lo < hi).then(|| (at(lo), at(hi)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, z: f64, s: f64) -> Vec<Point2> {
        vec![[x, z], [x + s, z], [x + s, z + s], [x, z + s]]
    }

    #[test]
    fn intersection_and_difference_add_up_to_the_polygon() {
        let (a, b) = (square(0.0, 0.0, 2.0), square(1.0, 0.5, 3.0));
        let rest: f64 = difference(&a, &b).iter().map(|p| twice_area(p)).sum();
        assert!((twice_area(&intersection(&a, &b)) - 3.0).abs() < 1e-12 && (rest - 5.0).abs() < 1e-12);
        assert!(intersection(&a, &square(5.0, 5.0, 1.0)).is_empty());
        let (p, q) = clip_segment(&a, [-1.0, 1.0], [5.0, 1.0]).unwrap();
        assert!(p == [0.0, 1.0] && q == [2.0, 1.0]);
        assert!(clip_segment(&a, [-1.0, 3.0], [5.0, 3.0]).is_none());
    }
}
