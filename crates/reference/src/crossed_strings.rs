//! View factors of walls in the plane (long ducts in cross-section) with occlusion, exact to rounding.
//!
//! F_ij L_i = ½ ∫ Σ (sin φ_Q − sin φ_P) dx over wall i, with the sum over the intervals of directions [φ_P, φ_Q] in which x sees wall
//! j and φ from the normal of i. The ends P, Q of an interval are ends of walls. They change only where x lies on the line through
//! two ends. Between two such points one test at the middle determines the order of the ends, and ∫ sin φ_P dx = |x_1 − P| − |x_2 − P|
//! is elementary: Hottel's crossed strings, one stretch of wall at a time.

/// A wall from (x, y) to (x, y); its front is to the left.
pub type Wall = [[f64; 2]; 2];

type Point2 = [f64; 2];

/// Relative size below which lengths and angles count as zero.
const RELATIVE_TOLERANCE: f64 = 1e-12;

fn minus(a: Point2, b: Point2) -> Point2 {
    [a[0] - b[0], a[1] - b[1]]
}
fn dot(a: Point2, b: Point2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn cross(a: Point2, b: Point2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
fn distance(a: Point2, b: Point2) -> f64 {
    let d = minus(a, b);
    d[0].hypot(d[1])
}

/// F_ij for all walls, row by row: the fraction of the radiation leaving the front of i that arrives at the front of j.
pub fn view_factors(walls: &[Wall]) -> Vec<Vec<f64>> {
    let mut ends: Vec<Point2> = walls.iter().flatten().copied().collect();
    ends.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    ends.dedup();
    (0..walls.len()).map(|i| view_factor_row(walls, &ends, i)).collect()
}

fn view_factor_row(walls: &[Wall], ends: &[Point2], i: usize) -> Vec<f64> {
    let [from, to] = walls[i];
    let length = distance(from, to);
    let at = |t: f64| [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t];
    let mut out = vec![0.0; walls.len()];
    let cuts = breakpoints(walls[i], ends);
    for w in cuts.windows(2).filter(|w| w[1] - w[0] > RELATIVE_TOLERANCE) {
        add_stretch(walls, ends, i, [at(w[0]), at(w[1])], &mut out);
    }
    out.iter_mut().for_each(|f| *f /= 2.0 * length);
    out
}

/// Parameters from 0 to 1, ascending, at which the line through two ends crosses the wall.
fn breakpoints([from, to]: Wall, ends: &[Point2]) -> Vec<f64> {
    let d = minus(to, from);
    let mut cuts = vec![0.0, 1.0];
    for (k, p) in ends.iter().enumerate() {
        for q in &ends[..k] {
            let e = minus(*q, *p);
            let denominator = cross(d, e);
            if denominator.abs() > RELATIVE_TOLERANCE * (dot(d, d) * dot(e, e)).sqrt() {
                let t = cross(minus(*p, from), e) / denominator;
                if t > 0.0 && t < 1.0 {
                    cuts.push(t);
                }
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Adds the strings of the stretch from a to b of wall i.
fn add_stretch(walls: &[Wall], ends: &[Point2], i: usize, [a, b]: [Point2; 2], out: &mut [f64]) {
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
        if dot(v, normal) > RELATIVE_TOLERANCE * length {
            rays.push((dot(v, along) / dot(v, v).sqrt(), distance(a, *p) - distance(b, *p)));
        }
    }
    rays.sort_by(|x, y| x.0.total_cmp(&y.0));
    for w in rays.windows(2).filter(|w| w[1].0 - w[0].0 > RELATIVE_TOLERANCE) {
        let s = 0.5 * (w[0].0 + w[1].0);
        let c = (1.0 - s * s).sqrt();
        let ray = [s * along[0] + c * normal[0], s * along[1] + c * normal[1]];
        if let Some(j) = first_wall(walls, i, middle, ray) {
            out[j] += w[1].1 - w[0].1;
        }
    }
}

/// True if a wall lies in the line of another one, such as its other side: from there it is seen edge-on, also by grazing rays that rounding puts beside it.
fn is_in_line([from, to]: Wall, ends: Wall) -> bool {
    let d = minus(to, from);
    let size = dot(d, d).sqrt();
    ends.iter().all(|p| {
        let v = minus(*p, from);
        cross(d, v).abs() <= RELATIVE_TOLERANCE * size * (size + dot(v, v).sqrt())
    })
}

/// The wall whose front is first on a ray; of two walls at one place the one that faces the ray.
fn first_wall(walls: &[Wall], i: usize, x: Point2, ray: Point2) -> Option<usize> {
    let mut best: Option<(f64, usize, bool)> = None;
    for (j, [p, q]) in walls.iter().enumerate() {
        let (e, v) = (minus(*q, *p), minus(*p, x));
        let (sp, sq) = (cross(ray, v), cross(ray, minus(*q, x)));
        if j == i || (sp > 0.0) == (sq > 0.0) || is_in_line(walls[i], [*p, *q]) {
            continue;
        }
        let denominator = cross(ray, e);
        let t = cross(v, e) / denominator;
        // The front is to the left of e: the ray comes from there if it turns clockwise to e.
        let front = denominator > 0.0;
        // Rounding moves a point that a ray meets at a grazing angle by the reciprocal of the angle.
        let equal = RELATIVE_TOLERANCE * (dot(e, e).sqrt() / denominator.abs()).max(1.0);
        if t > RELATIVE_TOLERANCE
            && best.is_none_or(|(s, _, f)| t < s * (1.0 - equal) || (t < s * (1.0 + equal) && front && !f))
        {
            best = Some((t, j, front));
        }
    }
    best.filter(|b| b.2).map(|b| b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet with two sides in a duct; its extension meets the ceiling 2e-5 beside a corner, which it thus sees at grazing angles.
    #[test]
    fn grazing_factors_of_sheets_are_those_of_strings() {
        let (top, bottom) = (
            [0.779_628_237_008_578_3, 0.472_655_394_235_181_8],
            [0.675_297_520_993_803, 0.153_733_168_917_554_73],
        );
        let corner = [0.876_487_604_969_015_2, 0.768_665_844_587_773_5];
        let ceiling = [corner, [-0.123_512_395_030_984_75, corner[1]]];
        let factors = view_factors(&[ceiling, [bottom, top], [top, bottom], [[1.0, 0.0], corner]]);
        // The line of the sheet meets the ceiling: (L + |top − corner| − |bottom − corner|)/(2 L), in 50 digits.
        let wanted = 6.402_601_339_605_149e-10;
        assert!((factors[2][0] - wanted).abs() < 1e-15, "{:e}", factors[2][0]);
    }

    /// Two sides of a sheet that some rays from the ceiling meet at grazing angles: no ray passes between the sides.
    #[test]
    fn rows_beside_sheets_in_a_closed_duct_sum_to_one() {
        let ring = [
            [0.0, 0.0],
            [1.0, 0.0],
            [0.974_942_564_924_326_1, 0.467_762_844_856_164_76],
            [-0.025_057_435_075_673_9, 0.467_762_844_856_164_76],
        ];
        let sheets = [
            [
                [0.094_988_512_984_865_23, 0.093_552_568_971_232_96],
                [0.173_387_807_528_698_23, 0.235_258_275_046_378_72],
            ],
            [
                [0.394_988_512_984_865_26, 0.093_552_568_971_232_96],
                [0.454_006_514_044_284_16, 0.369_746_794_362_670_94],
            ],
            [
                [0.694_988_512_984_865_2, 0.093_552_568_971_232_96],
                [0.670_810_012_814_621_4, 0.243_877_131_070_560_36],
            ],
        ];
        let mut walls: Vec<Wall> = [0, 1, 3, 2].map(|k| [ring[k], ring[(k + 1) % 4]]).to_vec();
        sheets.iter().for_each(|[p, q]| walls.extend([[*p, *q], [*q, *p]]));
        let factors = view_factors(&walls);
        for row in &factors {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{row:?}");
        }
        // In 50 digits.
        assert!((factors[3][6] - 0.104_429_594_797_786_27).abs() < 1e-14, "{:e}", factors[3][6]);
    }

    #[test]
    fn square_duct_with_and_without_a_plate_matches_crossed_strings() {
        let square = [
            [[0.0, 0.0], [1.0, 0.0]],
            [[1.0, 0.0], [1.0, 1.0]],
            [[1.0, 1.0], [0.0, 1.0]],
            [[0.0, 1.0], [0.0, 0.0]],
        ];
        let f = view_factors(&square);
        assert!((f[0][2] - (2f64.sqrt() - 1.0)).abs() < 1e-15);
        assert!((f[0][1] - (1.0 - 0.5 * 2f64.sqrt())).abs() < 1e-15);
        // A plate across the middle, each face a wall: floor and ceiling see each other past it on both sides.
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
