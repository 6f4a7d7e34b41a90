//! The hemi-cube of Cohen and Greenberg, extended to volumes by Rushmeier and Torrance: the renderers' baseline of its time.
//!
//! A patch is divided into pieces; half a cube of edge 2 is centred on each, its five faces rasters of pixels. A pixel
//! at (x, y) of the top, or at (x, z) of a side, covers a fraction of the cosine-weighted hemisphere,
//!
//!   ΔF_top = ΔA/(π (x² + y² + 1)²)      ΔF_side = z ΔA/(π (x² + z² + 1)²)      Σ ΔF → 1,
//!
//! and is a ray through its centre. It is assigned to the nearest plate on the ray; a box receives the ray length inside it, up to that
//! plate. With A the piece's area and the medium's e^{−κr} inside,
//!
//!   𝓕_ss ≈ Σ A ΔF e^{−κt}  (m²)      𝓕_sv ≈ Σ A ΔF ∫_{t₀}^{t₁} e^{−κt} dt  (m³)
//!
//! (Cohen and Greenberg, The hemi-cube, SIGGRAPH 1985; Rushmeier and Torrance, The zonal method, SIGGRAPH 1987.)
//!
//! **Error**, estimated. Edges: a raster moves them by half a pixel at most, hence half the sum over edge pixels. Pieces: one
//! point per piece, hence the difference to pieces of four times the area. Pixels: a sum in place of an integral over directions, hence the
//! difference to pixels of four times the area. The radius is the sum of the three.

use std::f64::consts::PI;
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Bounded, Vec3};
use zonal_scene::Plate;

/// A plate or box in front of a hemi-cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HemicubeTarget {
    /// A plate: its front exchanges, both sides occlude.
    Plate(Plate),
    /// A box of a medium, from its smallest to its largest coordinates, m. It does not occlude.
    Cuboid(Vec3, Vec3),
}

/// Resolution of a hemi-cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemicubeRaster {
    /// Pixels along an edge of the top: even, 4 or more.
    pub resolution: usize,
    /// Number of times the patch is quartered: 4^halvings pieces, each with a hemi-cube.
    pub halvings: u32,
}

/// First raster of [`pair_factor`].
const COARSEST_RASTER: HemicubeRaster = HemicubeRaster { resolution: 16, halvings: 1 };
/// Finest raster of [`pair_factor`].
const FINEST_RASTER: HemicubeRaster = HemicubeRaster { resolution: 256, halvings: 4 };

/// Returns the factors of one patch and many targets with mutual occlusion: m² for a plate, m³ for a box. `kappa` in 1/m.
///
/// # Panics
/// On a resolution that is odd or below 4.
pub fn patch_factors(
    patch: &Plate,
    targets: &[HemicubeTarget],
    kappa: f64,
    raster: HemicubeRaster,
) -> Vec<Factor> {
    assert!(raster.resolution >= 4 && raster.resolution.is_multiple_of(2), "{raster:?}");
    let errors = estimate_errors(patch, targets, kappa, raster);
    let factor = |e: &HemicubeErrors| Factor {
        bounded: Bounded::estimated(e.value, e.edges + e.pieces + e.pixels),
        evaluations: e.evaluations,
        method: Method::HemiCube,
    };
    errors.iter().map(factor).collect()
}

/// Returns the factor of one patch and one target. Pieces or pixels are refined, whichever has the larger error, until the radius meets the
/// request, the evaluations are spent or 256 pixels and four halvings are reached.
pub fn pair_factor(patch: &Plate, target: &HemicubeTarget, kappa: f64, demand: &AccuracyRequest) -> Factor {
    let (mut raster, mut spent) = (COARSEST_RASTER, 0);
    loop {
        let e = estimate_errors(patch, std::slice::from_ref(target), kappa, raster)[0];
        spent += e.evaluations;
        let radius = e.edges + e.pieces + e.pixels;
        let can = (raster.halvings < FINEST_RASTER.halvings, raster.resolution < FINEST_RASTER.resolution);
        if radius <= demand.radius(e.value) || spent >= demand.max_evaluations || can == (false, false) {
            let bounded = Bounded::estimated(e.value, radius);
            return Factor { bounded, evaluations: spent, method: Method::HemiCube };
        }
        if can.0 && (!can.1 || e.pieces > e.edges + e.pixels) {
            raster.halvings += 1;
        } else {
            raster.resolution *= 2;
        }
    }
}

/// A value and the three parts of its error.
#[derive(Clone, Copy, Debug, Default)]
struct HemicubeErrors {
    value: f64,
    edges: f64,
    pieces: f64,
    pixels: f64,
    evaluations: u64,
}

fn estimate_errors(
    patch: &Plate,
    targets: &[HemicubeTarget],
    kappa: f64,
    raster: HemicubeRaster,
) -> Vec<HemicubeErrors> {
    let HemicubeRaster { resolution, halvings } = raster;
    let fine = pixel_sums(patch, targets, kappa, resolution, halvings);
    let pixels = pixel_sums(patch, targets, kappa, resolution / 2, halvings);
    let pieces = match halvings {
        0 => vec![PixelSum::default(); targets.len()],
        _ => pixel_sums(patch, targets, kappa, resolution, halvings - 1),
    };
    let errors = |k: usize| HemicubeErrors {
        value: fine[k].value,
        edges: 0.5 * fine[k].edges,
        pieces: (fine[k].value - pieces[k].value).abs(),
        pixels: (fine[k].value - pixels[k].value).abs(),
        evaluations: fine[k].rays + pixels[k].rays + pieces[k].rays,
    };
    (0..targets.len()).map(errors).collect()
}

/// The sum over a target's pixels, that over its edge pixels, and the number of rays.
#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    value: f64,
    edges: f64,
    rays: u64,
}

fn pixel_sums(
    patch: &Plate,
    targets: &[HemicubeTarget],
    kappa: f64,
    resolution: usize,
    halvings: u32,
) -> Vec<PixelSum> {
    let mut pieces = vec![*patch];
    for _ in 0..halvings {
        pieces = pieces.iter().flat_map(Plate::quarters).collect();
    }
    let mut sums = vec![PixelSum::default(); targets.len()];
    for piece in &pieces {
        for face in HemicubeFace::faces_of(piece, resolution) {
            face.accumulate(targets, RayWeight { kappa, area: piece.area() }, &mut sums);
        }
    }
    sums
}

/// Weight of the rays of a piece: extinction, 1/m, and the area of the piece, m².
#[derive(Clone, Copy)]
struct RayWeight {
    kappa: f64,
    area: f64,
}

/// A face of the half cube: pixel (i, j) lies in the direction w + x u + y v from the eye.
struct HemicubeFace {
    eye: Vec3,
    u: Vec3,
    v: Vec3,
    w: Vec3,
    columns: usize,
    rows: usize,
    top: bool,
}

/// The nearest plate in a pixel.
#[derive(Clone, Copy)]
struct NearestPlate {
    distance: f64,
    target: usize,
}

const NO_PLATE: NearestPlate = NearestPlate { distance: f64::INFINITY, target: usize::MAX };

impl HemicubeFace {
    fn faces_of(piece: &Plate, resolution: usize) -> [HemicubeFace; 5] {
        let (eye, n) = (piece.centre(), piece.normal());
        let (t, b) = n.frame();
        let side = |w: Vec3, u: Vec3| HemicubeFace {
            eye,
            u,
            v: n,
            w,
            columns: resolution,
            rows: resolution / 2,
            top: false,
        };
        let top = HemicubeFace { eye, u: t, v: b, w: n, columns: resolution, rows: resolution, top: true };
        [top, side(t, b), side(-t, b), side(b, t), side(-b, t)]
    }

    fn step(&self) -> f64 {
        2.0 / self.columns as f64
    }

    fn x(&self, i: usize) -> f64 {
        (i as f64 + 0.5) * self.step() - 1.0
    }

    fn y(&self, j: usize) -> f64 {
        (j as f64 + 0.5) * self.step() - if self.top { 1.0 } else { 0.0 }
    }

    /// ΔF of a pixel and the unit direction through it.
    fn pixel(&self, i: usize, j: usize) -> (f64, Vec3) {
        let (x, y) = (self.x(i), self.y(j));
        let r2 = 1.0 + x * x + y * y;
        let cosine = if self.top { 1.0 } else { y };
        let delta = cosine * self.step().powi(2) / (PI * r2 * r2);
        (delta, (self.w + self.u * x + self.v * y) / r2.sqrt())
    }

    /// The columns and rows that the convex hull of some points can touch.
    fn pixel_window(&self, points: &[Vec3]) -> [std::ops::Range<usize>; 2] {
        let mut lo = [f64::INFINITY; 2];
        let mut hi = [f64::NEG_INFINITY; 2];
        let all = [0..self.columns, 0..self.rows];
        let depths = || points.iter().map(|p| self.w.dot(*p - self.eye));
        if depths().all(|d| d <= 0.0) {
            return [0..0, 0..0];
        }
        let near = 1e-9 * depths().fold(0.0, |s: f64, d| s.max(d.abs()));
        if depths().any(|d| d <= near) {
            return all;
        }
        for p in points {
            let d = *p - self.eye;
            for (k, axis) in [self.u, self.v].into_iter().enumerate() {
                let s = axis.dot(d) / self.w.dot(d);
                (lo[k], hi[k]) = (lo[k].min(s), hi[k].max(s));
            }
        }
        let from = [-1.0, if self.top { -1.0 } else { 0.0 }];
        std::array::from_fn(|k| {
            let cell = |s: f64| ((s - from[k]) / self.step()).clamp(0.0, all[k].end as f64);
            cell(lo[k]).floor() as usize..cell(hi[k]).ceil() as usize
        })
    }

    fn accumulate(&self, targets: &[HemicubeTarget], weight: RayWeight, sums: &mut [PixelSum]) {
        let mut buffer = vec![NO_PLATE; self.columns * self.rows];
        for (k, target) in targets.iter().enumerate() {
            if let HemicubeTarget::Plate(p) = target {
                self.rasterize_plate(k, p, &mut buffer, &mut sums[k]);
            }
        }
        self.score_plates(&buffer, targets, weight, sums);
        for (k, target) in targets.iter().enumerate() {
            if let HemicubeTarget::Cuboid(lo, hi) = target {
                self.score_cuboid([*lo, *hi], &buffer, weight, &mut sums[k]);
            }
        }
    }

    fn rasterize_plate(&self, k: usize, plate: &Plate, buffer: &mut [NearestPlate], sum: &mut PixelSum) {
        let (corners, n) = plate.corners();
        let [columns, rows] = self.pixel_window(&corners[..n]);
        sum.rays += (columns.len() * rows.len()) as u64;
        for j in rows {
            for i in columns.clone() {
                let item = &mut buffer[j * self.columns + i];
                if let Some(t) = intersect_plate(plate, self.eye, self.pixel(i, j).1)
                    && t < item.distance
                {
                    *item = NearestPlate { distance: t, target: k };
                }
            }
        }
    }

    fn score_plates(
        &self,
        buffer: &[NearestPlate],
        targets: &[HemicubeTarget],
        RayWeight { kappa, area }: RayWeight,
        sums: &mut [PixelSum],
    ) {
        let at = |i: usize, j: usize| buffer[j * self.columns + i].target;
        for j in 0..self.rows {
            for i in 0..self.columns {
                let item = buffer[j * self.columns + i];
                let others = [(i.wrapping_sub(1), j), (i + 1, j), (i, j.wrapping_sub(1)), (i, j + 1)];
                let inside = |o: &(usize, usize)| o.0 < self.columns && o.1 < self.rows;
                let (delta, ray) = self.pixel(i, j);
                let weight =
                    area * delta * if kappa > 0.0 { (-kappa * item.distance.min(1e300)).exp() } else { 1.0 };
                if let Some(HemicubeTarget::Plate(p)) = targets.get(item.target)
                    && p.normal().dot(ray) < 0.0
                {
                    sums[item.target].value += weight;
                    if others.iter().filter(|o| inside(o)).any(|o| at(o.0, o.1) != item.target) {
                        sums[item.target].edges += weight;
                    }
                }
            }
        }
    }

    fn score_cuboid(
        &self,
        [lo, hi]: [Vec3; 2],
        buffer: &[NearestPlate],
        RayWeight { kappa, area }: RayWeight,
        sum: &mut PixelSum,
    ) {
        let corner = |k: usize| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
            Vec3::from_array([pick(0), pick(1), pick(2)])
        };
        let [columns, rows] = self.pixel_window(&std::array::from_fn::<Vec3, 8, _>(corner));
        sum.rays += (columns.len() * rows.len()) as u64;
        // Contributions of the pixels, with a border of zeros around the window.
        let (across, mut shares) = (columns.len() + 2, vec![0.0; (columns.len() + 2) * (rows.len() + 2)]);
        for (b, j) in rows.clone().enumerate() {
            for (a, i) in columns.clone().enumerate() {
                let (delta, ray) = self.pixel(i, j);
                let (t0, t1) = box_chord(lo, hi, self.eye, ray);
                let t1 = t1.min(buffer[j * self.columns + i].distance);
                if t1 > t0 {
                    shares[(b + 1) * across + a + 1] = area * delta * attenuated_length(kappa, t0, t1);
                }
            }
        }
        for k in (0..shares.len()).filter(|k| shares[*k] > 0.0) {
            sum.value += shares[k];
            if [k - 1, k + 1, k - across, k + across].iter().any(|o| shares[*o] == 0.0) {
                sum.edges += shares[k];
            }
        }
    }
}

/// ∫ e^{−κt} dt from t₀ to t₁, m.
fn attenuated_length(kappa: f64, t0: f64, t1: f64) -> f64 {
    let s = t1 - t0;
    if kappa * s < 1e-8 {
        s * (-kappa * t0).exp()
    } else {
        -(-kappa * t0).exp() * (-kappa * s).exp_m1() / kappa
    }
}

/// Distance to a plate along a unit ray.
fn intersect_plate(plate: &Plate, eye: Vec3, ray: Vec3) -> Option<f64> {
    let n = plate.e1.cross(plate.e2);
    let t = n.dot(plate.origin - eye) / n.dot(ray);
    let d = eye + ray * t - plate.origin;
    let n2 = n.length2();
    let (u, v) = (d.cross(plate.e2).dot(n) / n2, plate.e1.cross(d).dot(n) / n2);
    let far = match plate.kind {
        zonal_scene::PlateKind::Triangle => u + v <= 1.0,
        zonal_scene::PlateKind::Parallelogram => u <= 1.0 && v <= 1.0,
    };
    (t > 0.0 && t.is_finite() && u >= 0.0 && v >= 0.0 && far).then_some(t)
}

/// Distances at which a ray enters and leaves a box, from the eye on; empty where it misses.
fn box_chord(lo: Vec3, hi: Vec3, eye: Vec3, ray: Vec3) -> (f64, f64) {
    let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        if ray[axis] == 0.0 {
            if eye[axis] < lo[axis] || eye[axis] > hi[axis] {
                return (0.0, 0.0);
            }
            continue;
        }
        let (a, b) = ((lo[axis] - eye[axis]) / ray[axis], (hi[axis] - eye[axis]) / ray[axis]);
        (t0, t1) = (t0.max(a.min(b)), t1.min(a.max(b)));
    }
    (t0, t1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::{Grade, vec3};

    fn square(z: f64) -> Plate {
        Plate::parallelogram(vec3(0.0, 0.0, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
    }

    fn wall() -> Plate {
        Plate::parallelogram(Vec3::ZERO, vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0))
    }

    #[test]
    fn pixel_form_factors_sum_to_one() {
        let total = |n: usize| -> f64 {
            let faces = HemicubeFace::faces_of(&square(0.0), n);
            faces
                .iter()
                .flat_map(|f| (0..f.columns * f.rows).map(move |k| f.pixel(k % f.columns, k / f.columns).0))
                .sum()
        };
        // The sum of a midpoint rule: a quarter of the error at half the step.
        let (a, b) = (total(32) - 1.0, total(64) - 1.0);
        assert!(a.abs() < 1e-3 && (a / b - 4.0).abs() < 0.05, "{a:e} {b:e}");
    }

    #[test]
    fn radius_contains_closed_forms_of_two_squares() {
        // C-11 and C-14 for unit squares.
        for (target, want) in [(square(1.0).flipped(), 0.199_824_895_698_39), (wall(), 0.200_043_776_075_4)] {
            let mut last = f64::INFINITY;
            for tolerance in [1e-1, 5e-2] {
                let f = pair_factor(
                    &square(0.0),
                    &HemicubeTarget::Plate(target),
                    0.0,
                    &AccuracyRequest::relative(tolerance),
                );
                assert_eq!((f.method, f.bounded.grade), (Method::HemiCube, Grade::Estimated));
                assert!(f.bounded.contains(want), "{f:?} {want}");
                assert!(f.bounded.radius <= tolerance * f.bounded.value && f.bounded.radius < last);
                last = f.bounded.radius;
            }
        }
    }

    #[test]
    fn two_triangles_sum_to_their_square() {
        let top = square(1.0).flipped();
        let half = |t: Plate| {
            pair_factor(&t, &HemicubeTarget::Plate(top), 0.5, &AccuracyRequest::relative(0.05)).bounded
        };
        let (c, _) = square(0.0).corners();
        let whole = half(square(0.0));
        let parts = half(Plate::triangle(c[0], c[1], c[2])) + half(Plate::triangle(c[0], c[2], c[3]));
        assert!((parts.value - whole.value).abs() < parts.radius + whole.radius);
    }

    #[test]
    fn evaluation_limit_ends_refinement() {
        let target = HemicubeTarget::Cuboid(vec3(0.0, 0.0, 0.0), Vec3::ONE);
        let f = pair_factor(
            &square(0.0),
            &target,
            1.0,
            &AccuracyRequest { tolerance: 1e-12, max_evaluations: 1 },
        );
        assert!(f.evaluations < 10_000 && f.bounded.radius > 0.0);
    }
}
