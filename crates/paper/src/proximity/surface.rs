//! Smooth surfaces and their local form: S(u₀ + x, v₀ + z) − S(u₀, v₀) as a sum of vectors times functions of x and of z out of
//! 1, x, cos x − 1, sin x. All of them are entire; their Taylor coefficients and their largest moduli on a disc are known.

use zonal_math::Vec3;

/// A smooth surface S(u, v). The front is the side of S_u × S_v, or the other one of a [`SmoothSurface::turned`] one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothSurface {
    kind: SurfaceKind,
    turned: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum SurfaceKind {
    Bilinear { o: Vec3, e1: Vec3, e2: Vec3, e3: Vec3 },
    Cone { o: Vec3, t: Vec3, b: Vec3, a: Vec3, tube: bool },
    Sphere { o: Vec3, t: Vec3, b: Vec3, a: Vec3 },
}

impl SmoothSurface {
    /// S = o + u e₁ + v e₂.
    pub fn plane(o: Vec3, e1: Vec3, e2: Vec3) -> SmoothSurface {
        SmoothSurface::ruled(o, e1, e2, Vec3::ZERO)
    }

    /// The bilinear ruled surface S = o + u e₁ + v e₂ + u v e₃.
    pub fn ruled(o: Vec3, e1: Vec3, e2: Vec3, e3: Vec3) -> SmoothSurface {
        SmoothSurface { kind: SurfaceKind::Bilinear { o, e1, e2, e3 }, turned: false }
    }

    /// A circular cylinder: u the angle about `axis` (a unit vector) from an arbitrary but fixed direction, v the height over `o`, m.
    /// The front is outside.
    pub fn cylinder(o: Vec3, axis: Vec3, radius: f64) -> SmoothSurface {
        let (t, b) = axis.frame();
        SmoothSurface {
            kind: SurfaceKind::Cone { o, t: t * radius, b: b * radius, a: axis, tube: true },
            turned: false,
        }
    }

    /// A circular cone with its apex at `o`: u the angle about `axis` (a unit vector), v > 0 the height along it, m; `slope` the
    /// radius at height one. The front is outside.
    pub fn cone(o: Vec3, axis: Vec3, slope: f64) -> SmoothSurface {
        let (t, b) = axis.frame();
        SmoothSurface {
            kind: SurfaceKind::Cone { o, t: t * slope, b: b * slope, a: axis, tube: false },
            turned: false,
        }
    }

    /// A sphere: u the longitude about `axis` (a unit vector), v the latitude. The front is outside.
    pub fn sphere(centre: Vec3, axis: Vec3, radius: f64) -> SmoothSurface {
        let (t, b) = axis.frame();
        SmoothSurface {
            kind: SurfaceKind::Sphere { o: centre, t: t * radius, b: b * radius, a: axis * radius },
            turned: false,
        }
    }

    /// The same surface with its front on the other side.
    pub fn turned(self) -> SmoothSurface {
        SmoothSurface { turned: !self.turned, ..self }
    }

    /// +1 if the front is that of S_u × S_v, −1 if not.
    pub(super) fn side(&self) -> f64 {
        if self.turned { -1.0 } else { 1.0 }
    }

    /// S(u, v), m.
    pub fn at(&self, u: f64, v: f64) -> Vec3 {
        match self.kind {
            SurfaceKind::Bilinear { o, e1, e2, e3 } => o + e1 * u + e2 * v + e3 * (u * v),
            SurfaceKind::Cone { o, t, b, a, tube } => {
                o + a * v + (t * u.cos() + b * u.sin()) * if tube { 1.0 } else { v }
            }
            SurfaceKind::Sphere { o, t, b, a } => o + (t * u.cos() + b * u.sin()) * v.cos() + a * v.sin(),
        }
    }

    /// S_u × S_v, pointing to the front: the unit normal times dA/(du dv).
    pub fn normal(&self, u: f64, v: f64) -> Vec3 {
        let local = self.local(u, v);
        local.slope(0).cross(local.slope(1)) * self.side()
    }

    /// Sum of the lengths from which S(u, v) is computed, m: the scale of its rounding errors.
    pub(super) fn magnitude(&self, u: f64, v: f64) -> f64 {
        match self.kind {
            SurfaceKind::Bilinear { o, e1, e2, e3 } => {
                o.length() + e1.length() * u.abs() + e2.length() * v.abs() + e3.length() * (u * v).abs()
            }
            SurfaceKind::Cone { o, t, b, a, tube } => {
                o.length()
                    + a.length() * v.abs()
                    + (t.length() + b.length()) * if tube { 1.0 } else { v.abs() }
            }
            SurfaceKind::Sphere { o, t, b, a } => o.length() + t.length() + b.length() + a.length(),
        }
    }

    /// The form about (u, v).
    pub(super) fn local(&self, u: f64, v: f64) -> LocalForm {
        use BasisFunction::{Constant, CosineMinusOne, Identity, Sine};
        let mut local =
            LocalForm { terms: [LocalTerm { c: Vec3::ZERO, size: 0.0, f: Constant, g: Constant }; 8], n: 0 };
        let turn = |t: Vec3, b: Vec3| {
            (t * u.cos() + b * u.sin(), b * u.cos() - t * u.sin(), t.length() + b.length())
        };
        match self.kind {
            SurfaceKind::Bilinear { e1, e2, e3, .. } => {
                local.add(e1 + e3 * v, e1.length() + e3.length() * v.abs(), Identity, Constant);
                local.add(e2 + e3 * u, e2.length() + e3.length() * u.abs(), Constant, Identity);
                local.add(e3, e3.length(), Identity, Identity);
            }
            SurfaceKind::Cone { t, b, a, tube, .. } => {
                let (t, b, size) = turn(t, b);
                let v = if tube { 1.0 } else { v };
                local.add(t * v, size * v.abs(), CosineMinusOne, Constant);
                local.add(b * v, size * v.abs(), Sine, Constant);
                if tube {
                    local.add(a, a.length(), Constant, Identity);
                } else {
                    local.add(a + t, a.length() + size, Constant, Identity);
                    local.add(t, size, CosineMinusOne, Identity);
                    local.add(b, size, Sine, Identity);
                }
            }
            SurfaceKind::Sphere { t, b, a, .. } => {
                let (t, b, size) = turn(t, b);
                let (s, c) = v.sin_cos();
                local.add(t * c + a * s, size + a.length(), Constant, CosineMinusOne);
                local.add(a * c - t * s, size + a.length(), Constant, Sine);
                local.add(t * c, size, CosineMinusOne, Constant);
                local.add(b * c, size, Sine, Constant);
                local.add(t * c, size, CosineMinusOne, CosineMinusOne);
                local.add(b * c, size, Sine, CosineMinusOne);
                local.add(t * -s, size, CosineMinusOne, Sine);
                local.add(b * -s, size, Sine, Sine);
            }
        }
        local
    }
}

/// The function itself or its first derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Derivative {
    Value,
    First,
}

impl Derivative {
    /// Of the functions of u and v for the partial derivative along `axis`.
    fn along(axis: usize) -> [Derivative; 2] {
        [0, 1].map(|k| if k == axis { Derivative::First } else { Derivative::Value })
    }
}

/// A function of one variable: 1, x, cos x − 1 or sin x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BasisFunction {
    Constant,
    Identity,
    CosineMinusOne,
    Sine,
}

impl BasisFunction {
    /// Taylor coefficients in ξ, x = step·ξ, of the function or of its derivative in x.
    pub(super) fn coefficients(self, step: f64, of: Derivative, out: &mut [f64]) {
        use Derivative::{First, Value};
        out.fill(0.0);
        let n = out.len();
        let mut power = 1.0;
        for k in 0..n {
            out[k] = match (self, of) {
                (BasisFunction::Constant, Value) | (BasisFunction::Identity, First) => f64::from(k == 0),
                (BasisFunction::Identity, Value) => power * f64::from(k == 1),
                (BasisFunction::Constant, First) => 0.0,
                (BasisFunction::CosineMinusOne, Value) if k == 0 => 0.0,
                (BasisFunction::CosineMinusOne, Value) | (BasisFunction::Sine, First) => {
                    power * [1.0, 0.0, -1.0, 0.0][k % 4]
                }
                (BasisFunction::Sine, Value) => power * [0.0, 1.0, 0.0, -1.0][k % 4],
                (BasisFunction::CosineMinusOne, First) => power * [0.0, -1.0, 0.0, 1.0][k % 4],
            };
            power *= step / (k + 1) as f64;
        }
    }

    /// The value at zero of the function or its derivative, and the largest modulus of the rest for |x| ≤ r.
    fn bound(self, r: f64, of: Derivative) -> (f64, f64) {
        use Derivative::{First, Value};
        match (self, of) {
            (BasisFunction::Constant, Value) => (1.0, 0.0),
            (BasisFunction::Constant, First) => (0.0, 0.0),
            (BasisFunction::Identity, Value) => (0.0, r),
            (BasisFunction::Identity, First) => (1.0, 0.0),
            (BasisFunction::CosineMinusOne, Value) => (0.0, 2.0 * (0.5 * r).sinh().powi(2)),
            (BasisFunction::Sine, First) => (1.0, 2.0 * (0.5 * r).sinh().powi(2)),
            (BasisFunction::Sine, Value) | (BasisFunction::CosineMinusOne, First) => (0.0, r.sinh()),
        }
    }
}

/// c f(x) g(z), with `size` the sum of the lengths from which c is computed.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalTerm {
    pub c: Vec3,
    pub size: f64,
    pub f: BasisFunction,
    pub g: BasisFunction,
}

impl LocalTerm {
    /// Largest |f g|, or that of its nonlinear part.
    fn modulus(&self, r: [f64; 2], curved: bool) -> f64 {
        let straight = |b: BasisFunction, r: f64| {
            if r < 1e-2 { r.powi(3) / 5.9 } else { b.bound(r, Derivative::Value).1 - r }
        };
        match (self.f, self.g) {
            (BasisFunction::Identity, BasisFunction::Constant)
            | (BasisFunction::Constant, BasisFunction::Identity)
                if curved =>
            {
                0.0
            }
            (BasisFunction::Sine, BasisFunction::Constant) if curved => straight(self.f, r[0]),
            (BasisFunction::Constant, BasisFunction::Sine) if curved => straight(self.g, r[1]),
            (f, g) => {
                let ((f0, f1), (g0, g1)) =
                    (f.bound(r[0], Derivative::Value), g.bound(r[1], Derivative::Value));
                (f0 + f1) * (g0 + g1)
            }
        }
    }
}

/// S(u₀ + x, v₀ + z) − S(u₀, v₀).
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalForm {
    terms: [LocalTerm; 8],
    n: usize,
}

/// Bounds for (x, z) = λ(x′, z′), (x′, z′) real, |x| ≤ r₁, |z| ≤ r₂, λ complex: on the real ones too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Majorant {
    /// |S − S₀|, m.
    pub displacement: f64,
    /// Its linear part x S_u + z S_v, a complex multiple of a real vector, m.
    pub linear: f64,
    /// The nonlinear part, m.
    pub rest: f64,
    /// |S_u|·|S_v| ≥ |S_u × S_v|, m².
    pub normal: f64,
    /// |S_u × S_v − (S_u × S_v)₀|, m².
    pub normal_change: f64,
}

impl LocalForm {
    fn add(&mut self, c: Vec3, size: f64, f: BasisFunction, g: BasisFunction) {
        if size > 0.0 {
            self.terms[self.n] = LocalTerm { c, size, f, g };
            self.n += 1;
        }
    }

    /// The terms, none of them zero.
    pub(super) fn terms(&self) -> &[LocalTerm] {
        &self.terms[..self.n]
    }

    /// S_u (axis 0) or S_v (axis 1) at the reference.
    pub(super) fn slope(&self, axis: usize) -> Vec3 {
        let [f, g] = Derivative::along(axis);
        self.terms().iter().fold(Vec3::ZERO, |s, t| s + t.c * (t.f.bound(0.0, f).0 * t.g.bound(0.0, g).0))
    }

    /// |f(0)g(0)| and the largest |f g − f(0)g(0)|, summed over the terms with their lengths.
    fn sum(&self, r: [f64; 2], of: [Derivative; 2]) -> (f64, f64) {
        self.terms().iter().fold((0.0, 0.0), |(at, off), t| {
            let ((f0, f1), (g0, g1)) = (t.f.bound(r[0], of[0]), t.g.bound(r[1], of[1]));
            let c = t.c.length();
            (at + c * f0 * g0, off + c * (f0 * g1 + f1 * (g0 + g1)))
        })
    }

    /// Bounds on the polydisc of radii `r`.
    pub(super) fn majorant(&self, r: [f64; 2]) -> Majorant {
        let (su, sv) = (self.slope(0) * r[0], self.slope(1) * r[1]);
        let linear = (su + sv).length().max((su - sv).length());
        // |Σ c φ|² ≤ ΣΣ |c_k·c_l| |φ_k| |φ_l|.
        let gram = |curved: bool| {
            let mut sum = 0.0;
            let moduli: [f64; 8] =
                std::array::from_fn(|k| if k < self.n { self.terms[k].modulus(r, curved) } else { 0.0 });
            for (k, s) in self.terms().iter().enumerate() {
                for (l, t) in self.terms()[..k].iter().enumerate() {
                    sum += 2.0 * s.c.dot(t.c).abs() * moduli[k] * moduli[l];
                }
                sum += s.c.length2() * moduli[k] * moduli[k];
            }
            sum.sqrt()
        };
        let rest = gram(true);
        let reach = gram(false).min(linear + rest);
        let slopes = [0, 1].map(|axis| (self.slope(axis).length(), self.sum(r, Derivative::along(axis)).1));
        let [(u0, u1), (v0, v1)] = slopes;
        Majorant {
            displacement: reach,
            linear,
            rest,
            normal: (u0 + u1) * (v0 + v1),
            normal_change: u1 * (v0 + v1) + u0 * v1,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use zonal_math::vec3;

    /// One surface of each kind, with a point inside its domain.
    pub(crate) fn one_of_each() -> [(SmoothSurface, [f64; 2]); 5] {
        let axis = vec3(0.2, -0.3, 0.9).normalized();
        let o = vec3(0.3, 0.1, -0.2);
        [
            (SmoothSurface::plane(o, vec3(1.0, 0.1, 0.0), vec3(0.2, 0.9, 0.1)), [0.4, 0.3]),
            (
                SmoothSurface::ruled(o, vec3(1.0, 0.1, 0.0), vec3(0.2, 0.9, 0.1), vec3(0.1, 0.0, 0.5)),
                [0.4, 0.3],
            ),
            (SmoothSurface::cylinder(o, axis, 0.8), [1.1, 0.5]),
            (SmoothSurface::cone(o, axis, 0.6), [2.1, 1.5]),
            (SmoothSurface::sphere(o, axis, 1.2), [-0.7, 0.4]),
        ]
    }

    #[test]
    fn local_form_equals_the_surface_and_is_below_its_majorants() {
        for (s, [u, v]) in one_of_each() {
            let local = s.local(u, v);
            let f = |b: BasisFunction, x: f64| match b {
                BasisFunction::Constant => 1.0,
                BasisFunction::Identity => x,
                BasisFunction::CosineMinusOne => x.cos() - 1.0,
                BasisFunction::Sine => x.sin(),
            };
            let h = 1e-6;
            for k in 0..64 {
                let (x, z) = (0.02 * (k % 8) as f64 - 0.08, 0.03 * (k / 8) as f64 - 0.1);
                let by_terms =
                    local.terms().iter().fold(Vec3::ZERO, |d, t| d + t.c * (f(t.f, x) * f(t.g, z)));
                let d = s.at(u + x, v + z) - s.at(u, v);
                assert!((by_terms - d).length() < 1e-14);
                let m = local.majorant([x.abs(), z.abs()]);
                assert!(d.length() <= m.displacement * (1.0 + 1e-12));
                let straight = local.slope(0) * x + local.slope(1) * z;
                assert!(straight.length() <= m.linear * (1.0 + 1e-12));
                assert!((d - straight).length() <= m.rest * (1.0 + 1e-12) + 1e-15);
                let n = s.normal(u + x, v + z);
                assert!(n.length() <= m.normal * (1.0 + 1e-12));
                assert!((n - s.normal(u, v)).length() <= m.normal_change * (1.0 + 1e-12) + 1e-15);
                let su = (s.at(u + x + h, v + z) - s.at(u + x - h, v + z)) / (2.0 * h);
                let sv = (s.at(u + x, v + z + h) - s.at(u + x, v + z - h)) / (2.0 * h);
                assert!((su.cross(sv) - n).length() < 1e-8);
            }
            assert_eq!(s.turned().normal(u, v), -s.normal(u, v));
        }
    }

    #[test]
    fn majorants_are_attained_by_imaginary_steps() {
        // A cylinder at x = ir: S − S₀ = (cosh r − 1) t + i sinh r b, Hermitian length ((cosh r − 1)² + sinh² r)^½.
        let s = SmoothSurface::cylinder(Vec3::ZERO, vec3(0.0, 0.0, 1.0), 1.0);
        let m = s.local(0.3, 0.0).majorant([0.5, 0.0]);
        let (c, h) = (0.5f64.cosh() - 1.0, 0.5f64.sinh());
        assert!((m.displacement - c.hypot(h)).abs() < 1e-14 && (m.linear - 0.5).abs() < 1e-15);
        assert!((m.rest - c.hypot(h - 0.5)).abs() < 1e-14);
    }
}
