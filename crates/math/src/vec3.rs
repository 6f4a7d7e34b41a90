//! Three-dimensional vectors in double precision.

use std::ops::{Add, AddAssign, Div, Index, Mul, Neg, Sub};

/// A point (m) or a direction.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// let (x, y) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
/// assert_eq!(x.cross(y).normalized(), vec3(0.0, 0.0, 1.0));
/// assert_eq!((x + y).length2(), 5.0);
/// assert_eq!(2.0 * x - y, vec3(2.0, -2.0, 0.0));
/// assert_eq!(Vec3::splat(1.0).max_abs(), 1.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(from = "[f64; 3]", into = "[f64; 3]")]
pub struct Vec3 {
    /// First component.
    pub x: f64,
    /// Second component.
    pub y: f64,
    /// Third component.
    pub z: f64,
}

impl From<[f64; 3]> for Vec3 {
    fn from(a: [f64; 3]) -> Vec3 {
        Vec3::from_array(a)
    }
}

impl From<Vec3> for [f64; 3] {
    fn from(v: Vec3) -> [f64; 3] {
        v.array()
    }
}

/// The vector (x, y, z).
#[inline]
pub const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

/// Largest |x| of a unit vector for which the x axis starts the orthonormal frame: then the cross product is not small.
const FRAME_AXIS_LIMIT: f64 = 0.6;

impl Vec3 {
    /// The origin.
    pub const ZERO: Vec3 = vec3(0.0, 0.0, 0.0);
    /// All components one.
    pub const ONE: Vec3 = vec3(1.0, 1.0, 1.0);

    /// All three components equal to `s`.
    #[inline]
    pub const fn splat(s: f64) -> Vec3 {
        vec3(s, s, s)
    }
    /// Scalar product.
    #[inline]
    pub fn dot(self, o: Vec3) -> f64 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }
    /// Vector product.
    #[inline]
    pub fn cross(self, o: Vec3) -> Vec3 {
        vec3(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }
    /// Square of the length.
    #[inline]
    pub fn length2(self) -> f64 {
        self.dot(self)
    }
    /// Length.
    #[inline]
    pub fn length(self) -> f64 {
        self.length2().sqrt()
    }
    /// The unit vector along `self`; the zero vector is returned unchanged.
    #[inline]
    pub fn normalized(self) -> Vec3 {
        let l = self.length();
        if l > 0.0 { self / l } else { self }
    }
    /// Componentwise product.
    #[inline]
    pub fn scale(self, o: Vec3) -> Vec3 {
        vec3(self.x * o.x, self.y * o.y, self.z * o.z)
    }
    /// Componentwise minimum.
    #[inline]
    pub fn min(self, o: Vec3) -> Vec3 {
        vec3(self.x.min(o.x), self.y.min(o.y), self.z.min(o.z))
    }
    /// Componentwise maximum.
    #[inline]
    pub fn max(self, o: Vec3) -> Vec3 {
        vec3(self.x.max(o.x), self.y.max(o.y), self.z.max(o.z))
    }
    /// Largest modulus among the components.
    #[inline]
    pub fn max_abs(self) -> f64 {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }
    /// Index of the largest component, the first of equal ones.
    #[inline]
    pub fn largest_axis(self) -> usize {
        (0..3).fold(0, |k, j| if self[j] > self[k] { j } else { k })
    }
    /// Product of the components: the volume of a box with these edges.
    #[inline]
    pub fn product(self) -> f64 {
        self.x * self.y * self.z
    }
    /// True when no component is NaN or infinite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
    /// The components as an array.
    #[inline]
    pub const fn array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
    /// A vector from an array.
    #[inline]
    pub const fn from_array(a: [f64; 3]) -> Vec3 {
        vec3(a[0], a[1], a[2])
    }
    /// Two unit vectors that complete the unit vector `self` to a right-handed orthonormal frame (t, b, self).
    #[inline]
    pub fn frame(self) -> (Vec3, Vec3) {
        let a = if self.x.abs() < FRAME_AXIS_LIMIT { vec3(1.0, 0.0, 0.0) } else { vec3(0.0, 1.0, 0.0) };
        let t = a.cross(self).normalized();
        (t, self.cross(t))
    }
}

/// Implements operators of a vector from the components of their result.
macro_rules! operators {
    ($($operator:ident::$method:ident($a:ident: $left:ty $(, $b:ident: $right:ty)?) = $result:expr;)+) => {
        $(impl $operator$(<$right>)? for $left {
            type Output = Vec3;
            #[inline]
            fn $method(self $(, $b: $right)?) -> Vec3 {
                let $a = self;
                $result
            }
        })+
    };
}

operators! {
    Add::add(a: Vec3, b: Vec3) = vec3(a.x + b.x, a.y + b.y, a.z + b.z);
    Sub::sub(a: Vec3, b: Vec3) = vec3(a.x - b.x, a.y - b.y, a.z - b.z);
    Mul::mul(a: Vec3, s: f64) = vec3(a.x * s, a.y * s, a.z * s);
    Mul::mul(s: f64, a: Vec3) = a * s;
    Div::div(a: Vec3, s: f64) = vec3(a.x / s, a.y / s, a.z / s);
    Neg::neg(a: Vec3) = vec3(-a.x, -a.y, -a.z);
}

impl AddAssign for Vec3 {
    #[inline]
    fn add_assign(&mut self, o: Vec3) {
        *self = *self + o;
    }
}
impl Index<usize> for Vec3 {
    type Output = f64;
    #[inline]
    fn index(&self, axis: usize) -> &f64 {
        match axis {
            0 => &self.x,
            1 => &self.y,
            _ => &self.z,
        }
    }
}
