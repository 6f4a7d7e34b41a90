//! View factors of two aligned rectangles without a medium, in closed form: the corner sums behind C-11 and C-14 in [`Wide`].
//!
//! Parallel planes c apart, with t the difference of the corners (x twice integrated, y twice):
//!
//! ```text
//! π𝓕 = Σ ± ½ [ y √(x²+c²) atan(y/√(x²+c²)) + x √(y²+c²) atan(x/√(y²+c²)) − ½ c² ln(x²+y²+c²) ].
//! ```
//!
//! Perpendicular planes, y along both, x and z the distances from their common line, ρ² = x² + z²:
//!
//! ```text
//! π𝓕 = Σ ± (−¼) [ ½ (y²−ρ²) ln(ρ²+y²) + 2 ρ y atan(y/ρ) ],     ∂²/∂y² of [...] = ln(ρ²+y²) + 1.
//! ```
//!
//! The sum cancels what the distance exceeds the sizes by, to the fourth power; a hundred bits bear 10⁴.

use crate::factors::{Answer, Block};
use crate::wide::{PI, Wide, difference};

/// Second difference in an axis along both rectangles: t at the four pairs of ends, with signs.
fn ends(a: &Block, b: &Block, k: usize) -> [(Wide, f64); 4] {
    let d = |x: f64, y: f64| difference(x, y);
    [
        (d(b.hi[k], a.lo[k]), 1.0),
        (d(b.hi[k], a.hi[k]), -1.0),
        (d(b.lo[k], a.lo[k]), -1.0),
        (d(b.lo[k], a.hi[k]), 1.0),
    ]
}

fn abs(x: Wide) -> Wide {
    if x.hi < 0.0 { -x } else { x }
}

/// ln of a number that may be zero where its factor is.
fn ln_or_zero(x: Wide) -> Wide {
    if x.hi > 0.0 { x.ln() } else { Wide::ZERO }
}

struct Sum {
    total: Wide,
    size: f64,
}

impl Sum {
    fn add(&mut self, x: Wide, sign: f64) {
        self.total = self.total + x * Wide::from(sign);
        self.size += x.hi.abs();
    }
    fn answer(&self) -> Answer {
        let value = (self.total / PI).rounded();
        // The functions are good to 1e−29 of their arguments' size.
        Answer { value, error: 1e-28 * self.size + 0.5 * f64::EPSILON * value.abs() }
    }
}

/// The factor of two rectangles that see each other fully (each wholly in front of the other, planes parallel or perpendicular);
/// `None` for anything else.
pub fn rectangles(a: &Block, b: &Block) -> Option<Answer> {
    let ((p, s), (q, u)) = (a.normal?, b.normal?);
    if p == q {
        let c = difference(b.lo[p], a.lo[p]);
        let c = if s > 0 { c } else { -c };
        if s == u || !c.is_positive() {
            return None;
        }
        return Some(parallel(ends(a, b, (p + 1) % 3), ends(a, b, (p + 2) % 3), c));
    }
    // Distances of b from the plane of a, and of a from the plane of b, in front.
    let along = |x: &Block, k: usize, sign: i8, plane: f64| {
        let (l, h) = (difference(x.lo[k], plane), difference(x.hi[k], plane));
        if sign > 0 { [l, h] } else { [-h, -l] }
    };
    let (x, z) = (along(b, p, s, a.lo[p]), along(a, q, u, b.lo[q]));
    if x[0].hi < 0.0 || z[0].hi < 0.0 {
        return None;
    }
    Some(perpendicular(x, z, ends(a, b, 3 - p - q)))
}

fn parallel(xs: [(Wide, f64); 4], ys: [(Wide, f64); 4], c: Wide) -> Answer {
    let (half, c2) = (Wide::from(0.5), c * c);
    let mut sum = Sum { total: Wide::ZERO, size: 0.0 };
    for (x, sx) in xs {
        for (y, sy) in ys {
            let (x, y) = (abs(x), abs(y));
            let (rx, ry) = ((x * x + c2).sqrt(), (y * y + c2).sqrt());
            let arcs = y * rx * y.atan2(rx) + x * ry * x.atan2(ry);
            let log = half * c2 * (x * x + y * y + c2).ln();
            sum.add(half * (arcs - log), sx * sy);
        }
    }
    sum.answer()
}

fn perpendicular(xs: [Wide; 2], zs: [Wide; 2], ys: [(Wide, f64); 4]) -> Answer {
    let half = Wide::from(0.5);
    let mut sum = Sum { total: Wide::ZERO, size: 0.0 };
    for (i, x) in xs.into_iter().enumerate() {
        for (j, z) in zs.into_iter().enumerate() {
            let rho2 = x * x + z * z;
            let rho = rho2.sqrt();
            for (y, sy) in ys {
                let y = abs(y);
                let y2 = y * y;
                let log = half * (y2 - rho2) * ln_or_zero(rho2 + y2);
                let arc = Wide::from(2.0) * rho * y * y.atan2(rho);
                let sign = if i == j { -0.25 } else { 0.25 };
                sum.add(log + arc, sign * sy);
            }
        }
    }
    sum.answer()
}
