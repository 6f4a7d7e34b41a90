//! Smooth surfaces with their local form: S(u₀ + x, v₀ + z) − S(u₀, v₀) as a sum of vectors times functions of x and of z out of
//! 1, x, cos x − 1, sin x. All of them are entire; their Taylor coefficients and their largest moduli on a disc are known.

use zonal_math::Vec3;

/// A smooth surface S(u, v). The front is the side of S_u × S_v, or the other one of a [`Surface::turned`] one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    kind: Kind,
    turned: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Bilinear { o: Vec3, e1: Vec3, e2: Vec3, e3: Vec3 },
    Cone { o: Vec3, t: Vec3, b: Vec3, a: Vec3, tube: bool },
    Sphere { o: Vec3, t: Vec3, b: Vec3, a: Vec3 },
}

impl Surface {
    /// S = o + u e₁ + v e₂.
    pub fn plane(o: Vec3, e1: Vec3, e2: Vec3) -> Surface {
        Surface::ruled(o, e1, e2, Vec3::ZERO)
    }

    /// The bilinear ruled surface S = o + u e₁ + v e₂ + u v e₃.
    pub fn ruled(o: Vec3, e1: Vec3, e2: Vec3, e3: Vec3) -> Surface {
        Surface { kind: Kind::Bilinear { o, e1, e2, e3 }, turned: false }
    }

    /// A circular cylinder: u the angle about `axis` (a unit vector) from an arbitrary but fixed direction, v the height over `o`, m.
    /// The front is outside.
    pub fn cylinder(o: Vec3, axis: Vec3, radius: f64) -> Surface {
        let (t, b) = axis.frame();
        Surface { kind: Kind::Cone { o, t: t * radius, b: b * radius, a: axis, tube: true }, turned: false }
    }

    /// A circular cone with its apex at `o`: u the angle about `axis` (a unit vector), v > 0 the height along it, m; `slope` the
    /// radius at height one. The front is outside.
    pub fn cone(o: Vec3, axis: Vec3, slope: f64) -> Surface {
        let (t, b) = axis.frame();
        Surface { kind: Kind::Cone { o, t: t * slope, b: b * slope, a: axis, tube: false }, turned: false }
    }

    /// A sphere: u the longitude about `axis` (a unit vector), v the latitude. The front is outside.
    pub fn sphere(centre: Vec3, axis: Vec3, radius: f64) -> Surface {
        let (t, b) = axis.frame();
        Surface {
            kind: Kind::Sphere { o: centre, t: t * radius, b: b * radius, a: axis * radius },
            turned: false,
        }
    }

    /// The same surface with its front on the other side.
    pub fn turned(self) -> Surface {
        Surface { turned: !self.turned, ..self }
    }

    /// +1 if the front is that of S_u × S_v, −1 if not.
    pub(super) fn side(&self) -> f64 {
        if self.turned { -1.0 } else { 1.0 }
    }

    /// S(u, v), m.
    pub fn at(&self, u: f64, v: f64) -> Vec3 {
        match self.kind {
            Kind::Bilinear { o, e1, e2, e3 } => o + e1 * u + e2 * v + e3 * (u * v),
            Kind::Cone { o, t, b, a, tube } => {
                o + a * v + (t * u.cos() + b * u.sin()) * if tube { 1.0 } else { v }
            }
            Kind::Sphere { o, t, b, a } => o + (t * u.cos() + b * u.sin()) * v.cos() + a * v.sin(),
        }
    }

    /// S_u × S_v, pointing to the front: the unit normal times dA/(du dv).
    pub fn normal(&self, u: f64, v: f64) -> Vec3 {
        let local = self.local(u, v);
        local.slope(0).cross(local.slope(1)) * self.side()
    }

    /// Lengths that S is summed from at (u, v), m: what its rounding errors are relative to.
    pub(super) fn magnitude(&self, u: f64, v: f64) -> f64 {
        match self.kind {
            Kind::Bilinear { o, e1, e2, e3 } => {
                o.length() + e1.length() * u.abs() + e2.length() * v.abs() + e3.length() * (u * v).abs()
            }
            Kind::Cone { o, t, b, a, tube } => {
                o.length()
                    + a.length() * v.abs()
                    + (t.length() + b.length()) * if tube { 1.0 } else { v.abs() }
            }
            Kind::Sphere { o, t, b, a } => o.length() + t.length() + b.length() + a.length(),
        }
    }

    /// The form about (u, v).
    pub(super) fn local(&self, u: f64, v: f64) -> Local {
        use Basis::{Bow, Line, One, Sine};
        let mut local = Local { terms: [Term { c: Vec3::ZERO, size: 0.0, f: One, g: One }; 8], n: 0 };
        let turn = |t: Vec3, b: Vec3| {
            (t * u.cos() + b * u.sin(), b * u.cos() - t * u.sin(), t.length() + b.length())
        };
        match self.kind {
            Kind::Bilinear { e1, e2, e3, .. } => {
                local.add(e1 + e3 * v, e1.length() + e3.length() * v.abs(), Line, One);
                local.add(e2 + e3 * u, e2.length() + e3.length() * u.abs(), One, Line);
                local.add(e3, e3.length(), Line, Line);
            }
            Kind::Cone { t, b, a, tube, .. } => {
                let (t, b, size) = turn(t, b);
                let v = if tube { 1.0 } else { v };
                local.add(t * v, size * v.abs(), Bow, One);
                local.add(b * v, size * v.abs(), Sine, One);
                if tube {
                    local.add(a, a.length(), One, Line);
                } else {
                    local.add(a + t, a.length() + size, One, Line);
                    local.add(t, size, Bow, Line);
                    local.add(b, size, Sine, Line);
                }
            }
            Kind::Sphere { t, b, a, .. } => {
                let (t, b, size) = turn(t, b);
                let (s, c) = v.sin_cos();
                local.add(t * c + a * s, size + a.length(), One, Bow);
                local.add(a * c - t * s, size + a.length(), One, Sine);
                local.add(t * c, size, Bow, One);
                local.add(b * c, size, Sine, One);
                local.add(t * c, size, Bow, Bow);
                local.add(b * c, size, Sine, Bow);
                local.add(t * -s, size, Bow, Sine);
                local.add(b * -s, size, Sine, Sine);
            }
        }
        local
    }
}

/// A function of one variable: 1, x, cos x − 1 or sin x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    One,
    Line,
    Bow,
    Sine,
}

impl Basis {
    /// Taylor coefficients in ξ, x = step·ξ, of the function or of its derivative in x.
    pub(super) fn coefficients(self, step: f64, derived: bool, out: &mut [f64]) {
        out.fill(0.0);
        let n = out.len();
        let mut power = 1.0;
        for k in 0..n {
            out[k] = match (self, derived) {
                (Basis::One, false) | (Basis::Line, true) => f64::from(k == 0),
                (Basis::Line, false) => power * f64::from(k == 1),
                (Basis::One, true) => 0.0,
                (Basis::Bow, false) if k == 0 => 0.0,
                (Basis::Bow, false) | (Basis::Sine, true) => power * [1.0, 0.0, -1.0, 0.0][k % 4],
                (Basis::Sine, false) => power * [0.0, 1.0, 0.0, -1.0][k % 4],
                (Basis::Bow, true) => power * [0.0, -1.0, 0.0, 1.0][k % 4],
            };
            power *= step / (k + 1) as f64;
        }
    }

    /// The value at zero of the function or its derivative, and the largest modulus of the rest for |x| ≤ r.
    fn bound(self, r: f64, derived: bool) -> (f64, f64) {
        match (self, derived) {
            (Basis::One, false) => (1.0, 0.0),
            (Basis::One, true) => (0.0, 0.0),
            (Basis::Line, false) => (0.0, r),
            (Basis::Line, true) => (1.0, 0.0),
            (Basis::Bow, false) => (0.0, 2.0 * (0.5 * r).sinh().powi(2)),
            (Basis::Sine, true) => (1.0, 2.0 * (0.5 * r).sinh().powi(2)),
            (Basis::Sine, false) | (Basis::Bow, true) => (0.0, r.sinh()),
        }
    }
}

/// c f(x) g(z), with `size` what c was summed from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub c: Vec3,
    pub size: f64,
    pub f: Basis,
    pub g: Basis,
}

impl Term {
    /// The largest |f g|, or of what is left of it without its linear part.
    fn modulus(&self, r: [f64; 2], curved: bool) -> f64 {
        let straight = |b: Basis, r: f64| if r < 1e-2 { r.powi(3) / 5.9 } else { b.bound(r, false).1 - r };
        match (self.f, self.g) {
            (Basis::Line, Basis::One) | (Basis::One, Basis::Line) if curved => 0.0,
            (Basis::Sine, Basis::One) if curved => straight(self.f, r[0]),
            (Basis::One, Basis::Sine) if curved => straight(self.g, r[1]),
            (f, g) => {
                let ((f0, f1), (g0, g1)) = (f.bound(r[0], false), g.bound(r[1], false));
                (f0 + f1) * (g0 + g1)
            }
        }
    }
}

/// S(u₀ + x, v₀ + z) − S(u₀, v₀).
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    terms: [Term; 8],
    n: usize,
}

/// Bounds for (x, z) = λ(x′, z′), (x′, z′) real, |x| ≤ r₁, |z| ≤ r₂, λ complex: on the real ones too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Majorant {
    /// |S − S₀|, m.
    pub reach: f64,
    /// Its linear part x S_u + z S_v, a complex multiple of a real vector, m.
    pub linear: f64,
    /// What is not linear, m.
    pub rest: f64,
    /// |S_u|·|S_v| ≥ |S_u × S_v|, m².
    pub normal: f64,
    /// |S_u × S_v − (S_u × S_v)₀|, m².
    pub bend: f64,
}

impl Local {
    fn add(&mut self, c: Vec3, size: f64, f: Basis, g: Basis) {
        if size > 0.0 {
            self.terms[self.n] = Term { c, size, f, g };
            self.n += 1;
        }
    }

    /// The terms, none of them zero.
    pub(super) fn terms(&self) -> &[Term] {
        &self.terms[..self.n]
    }

    /// S_u (axis 0) or S_v (axis 1) at the reference.
    pub(super) fn slope(&self, axis: usize) -> Vec3 {
        self.terms()
            .iter()
            .fold(Vec3::ZERO, |s, t| s + t.c * (t.f.bound(0.0, axis == 0).0 * t.g.bound(0.0, axis == 1).0))
    }

    /// |f(0)g(0)| and the largest |f g − f(0)g(0)|, summed over the terms with their lengths.
    fn sum(&self, r: [f64; 2], derived: [bool; 2]) -> (f64, f64) {
        self.terms().iter().fold((0.0, 0.0), |(at, off), t| {
            let ((f0, f1), (g0, g1)) = (t.f.bound(r[0], derived[0]), t.g.bound(r[1], derived[1]));
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
        let slopes = [0, 1].map(|axis| (self.slope(axis).length(), self.sum(r, [axis == 0, axis == 1]).1));
        let [(u0, u1), (v0, v1)] = slopes;
        Majorant { reach, linear, rest, normal: (u0 + u1) * (v0 + v1), bend: u1 * (v0 + v1) + u0 * v1 }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use zonal_math::vec3;

    /// One surface of each kind, with a point and steps in the middle of things.
    pub(in super::super) fn one_of_each() -> [(Surface, [f64; 2]); 5] {
        let axis = vec3(0.2, -0.3, 0.9).normalized();
        let o = vec3(0.3, 0.1, -0.2);
        [
            (Surface::plane(o, vec3(1.0, 0.1, 0.0), vec3(0.2, 0.9, 0.1)), [0.4, 0.3]),
            (Surface::ruled(o, vec3(1.0, 0.1, 0.0), vec3(0.2, 0.9, 0.1), vec3(0.1, 0.0, 0.5)), [0.4, 0.3]),
            (Surface::cylinder(o, axis, 0.8), [1.1, 0.5]),
            (Surface::cone(o, axis, 0.6), [2.1, 1.5]),
            (Surface::sphere(o, axis, 1.2), [-0.7, 0.4]),
        ]
    }

    #[test]
    fn the_local_form_is_the_surface_and_stays_below_its_majorants() {
        for (s, [u, v]) in one_of_each() {
            let local = s.local(u, v);
            let f = |b: Basis, x: f64| match b {
                Basis::One => 1.0,
                Basis::Line => x,
                Basis::Bow => x.cos() - 1.0,
                Basis::Sine => x.sin(),
            };
            let h = 1e-6;
            for k in 0..64 {
                let (x, z) = (0.02 * (k % 8) as f64 - 0.08, 0.03 * (k / 8) as f64 - 0.1);
                let by_terms =
                    local.terms().iter().fold(Vec3::ZERO, |d, t| d + t.c * (f(t.f, x) * f(t.g, z)));
                let d = s.at(u + x, v + z) - s.at(u, v);
                assert!((by_terms - d).length() < 1e-14);
                let m = local.majorant([x.abs(), z.abs()]);
                assert!(d.length() <= m.reach * (1.0 + 1e-12));
                let straight = local.slope(0) * x + local.slope(1) * z;
                assert!(straight.length() <= m.linear * (1.0 + 1e-12));
                assert!((d - straight).length() <= m.rest * (1.0 + 1e-12) + 1e-15);
                let n = s.normal(u + x, v + z);
                assert!(n.length() <= m.normal * (1.0 + 1e-12));
                assert!((n - s.normal(u, v)).length() <= m.bend * (1.0 + 1e-12) + 1e-15);
                let su = (s.at(u + x + h, v + z) - s.at(u + x - h, v + z)) / (2.0 * h);
                let sv = (s.at(u + x, v + z + h) - s.at(u + x, v + z - h)) / (2.0 * h);
                assert!((su.cross(sv) - n).length() < 1e-8);
            }
            assert_eq!(s.turned().normal(u, v), -s.normal(u, v));
        }
    }

    #[test]
    fn the_majorants_are_reached_by_imaginary_steps() {
        // A cylinder at x = ir: S − S₀ = (cosh r − 1) t + i sinh r b, Hermitian length ((cosh r − 1)² + sinh² r)^½.
        let s = Surface::cylinder(Vec3::ZERO, vec3(0.0, 0.0, 1.0), 1.0);
        let m = s.local(0.3, 0.0).majorant([0.5, 0.0]);
        let (c, h) = (0.5f64.cosh() - 1.0, 0.5f64.sinh());
        assert!((m.reach - c.hypot(h)).abs() < 1e-14 && (m.linear - 0.5).abs() < 1e-15);
        assert!((m.rest - c.hypot(h - 0.5)).abs() < 1e-14);
    }
}
