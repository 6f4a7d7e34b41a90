//! Eight single-precision numbers in one vector register, with comparisons as bit masks: the arithmetic of an eight-wide tree of boxes.
//!
//! A [`F32x8Kernel`] is compiled twice, for AVX2 and for plain arrays; [`F32x8Dispatch::run`] takes the version that the processor supports.
//! Every operation is one of IEEE 754 and none is contracted to a fused multiply-add, so that all processors return the same bits.
//!
//! ```
//! use zonal_math::simd::f32x8::{F32x8, F32x8Dispatch, F32x8Kernel, F32x8Ops};
//!
//! /// Which of eight numbers are at most one.
//! struct AtMostOne(F32x8);
//! impl F32x8Kernel for AtMostOne {
//!     type Output = u32;
//!     #[inline(always)]
//!     fn evaluate<V: F32x8Ops>(self, ops: V) -> u32 {
//!         ops.le(ops.load(&self.0), ops.splat(1.0))
//!     }
//! }
//! let x = [0.0, 1.0, 2.0, 3.0, -1.0, 4.0, 5.0, 6.0];
//! assert_eq!(F32x8Dispatch::detect().run(AtMostOne(x)), 0b0001_0011);
//! assert_eq!(F32x8Dispatch::scalar().run(AtMostOne(x)), 0b0001_0011);
//! ```

/// One number for each of the eight lanes.
pub type F32x8 = [f32; 8];

/// Arithmetic on eight lanes. `min(a, b)` is `a` where a < b, else `b`; `max(a, b)` is `a` where a > b, else `b`, as the x86 instructions.
pub trait F32x8Ops: Copy {
    /// The vector register, or an array in its place.
    type Vector: Copy;
    /// Copies `x` to all lanes.
    fn splat(self, x: f32) -> Self::Vector;
    /// Loads eight numbers from memory.
    fn load(self, x: &F32x8) -> Self::Vector;
    /// Stores eight numbers to memory.
    fn store(self, x: Self::Vector) -> F32x8;
    /// a + b
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// a − b
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// a b
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The minimum in each lane.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The maximum in each lane.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Mask whose bit l is set where a ≤ b in lane l.
    fn le(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Asks the processor to load the cache line at the start of `x`; changes no result.
    fn prefetch<T>(self, x: &T);
}

/// A computation on eight lanes. `evaluate` and every function that it calls must be `#[inline(always)]`, else they are compiled without
/// the vector instructions.
pub trait F32x8Kernel {
    /// The result.
    type Output;
    /// Runs the computation with the given operations.
    fn evaluate<V: F32x8Ops>(self, ops: V) -> Self::Output;
}

/// The instruction set that the processor supports.
#[derive(Clone, Copy, Debug)]
pub struct F32x8Dispatch {
    #[cfg(target_arch = "x86_64")]
    avx2: Option<pulp::x86::V3>,
}

impl F32x8Dispatch {
    /// Detects the instruction set of the processor.
    pub fn detect() -> F32x8Dispatch {
        F32x8Dispatch {
            #[cfg(target_arch = "x86_64")]
            avx2: pulp::x86::V3::try_new(),
        }
    }
    /// Scalar code on every processor, for comparison.
    pub fn scalar() -> F32x8Dispatch {
        F32x8Dispatch {
            #[cfg(target_arch = "x86_64")]
            avx2: None,
        }
    }
    /// Runs a kernel with the detected instruction set.
    #[inline(always)]
    pub fn run<T: F32x8Kernel>(self, kernel: T) -> T::Output {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = self.avx2 {
            return v3.vectorize(Avx2Call { v3, kernel });
        }
        run_scalar(kernel)
    }
}

/// Runs a kernel on arrays. In a function of its own: its arrays in the frame of the caller made rays 5 % slower on processors that never call it.
#[inline(never)]
fn run_scalar<T: F32x8Kernel>(kernel: T) -> T::Output {
    kernel.evaluate(ScalarF32x8)
}

#[cfg(target_arch = "x86_64")]
struct Avx2Call<T> {
    v3: pulp::x86::V3,
    kernel: T,
}

#[cfg(target_arch = "x86_64")]
impl<T: F32x8Kernel> pulp::NullaryFnOnce for Avx2Call<T> {
    type Output = T::Output;
    #[inline(always)]
    fn call(self) -> T::Output {
        self.kernel.evaluate(self.v3)
    }
}

/// Methods of [`F32x8Ops`] with two vectors `$a` and `$b`.
macro_rules! binary_operations {
    ($self:ident, $a:ident: $vector:ty, $b:ident; $($name:ident = $result:expr;)+) => {
        $(#[inline(always)]
        fn $name($self, $a: $vector, $b: $vector) -> $vector {
            $result
        })+
    };
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{F32x8, F32x8Ops};
    use pulp::bytemuck::cast;
    use pulp::x86::V3;
    use std::arch::x86_64::{__m256, _CMP_LE_OQ, _MM_HINT_T0};

    impl F32x8Ops for V3 {
        type Vector = __m256;
        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            self.avx._mm256_set1_ps(x)
        }
        #[inline(always)]
        fn load(self, x: &F32x8) -> __m256 {
            cast(*x)
        }
        #[inline(always)]
        fn store(self, x: __m256) -> F32x8 {
            cast(x)
        }
        binary_operations! { self, a: __m256, b;
            add = self.avx._mm256_add_ps(a, b);
            sub = self.avx._mm256_sub_ps(a, b);
            mul = self.avx._mm256_mul_ps(a, b);
            min = self.avx._mm256_min_ps(a, b);
            max = self.avx._mm256_max_ps(a, b);
        }
        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> u32 {
            let mask = self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
            self.avx._mm256_movemask_ps(mask) as u32
        }
        #[inline(always)]
        fn prefetch<T>(self, x: &T) {
            self.sse._mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(x).cast());
        }
    }
}

/// Scalar code on arrays of eight numbers.
#[derive(Clone, Copy, Debug)]
struct ScalarF32x8;

#[inline(always)]
fn map_lanes(a: F32x8, b: F32x8, f: impl Fn(f32, f32) -> f32) -> F32x8 {
    std::array::from_fn(|l| f(a[l], b[l]))
}

impl F32x8Ops for ScalarF32x8 {
    type Vector = F32x8;
    #[inline(always)]
    fn splat(self, x: f32) -> F32x8 {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, x: &F32x8) -> F32x8 {
        *x
    }
    #[inline(always)]
    fn store(self, x: F32x8) -> F32x8 {
        x
    }
    binary_operations! { self, a: F32x8, b;
        add = map_lanes(a, b, |a, b| a + b);
        sub = map_lanes(a, b, |a, b| a - b);
        mul = map_lanes(a, b, |a, b| a * b);
        min = map_lanes(a, b, |a, b| if a < b { a } else { b });
        max = map_lanes(a, b, |a, b| if a > b { a } else { b });
    }
    #[inline(always)]
    fn le(self, a: F32x8, b: F32x8) -> u32 {
        (0..8).fold(0, |m, l| m | u32::from(a[l] <= b[l]) << l)
    }
    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    struct AllOperations(F32x8, F32x8);

    impl F32x8Kernel for AllOperations {
        type Output = ([F32x8; 6], u32);
        #[inline(always)]
        fn evaluate<V: F32x8Ops>(self, w: V) -> Self::Output {
            let (a, b) = (w.load(&self.0), w.load(&self.1));
            let all = [w.add(a, b), w.sub(a, b), w.mul(a, b), w.min(a, b), w.max(a, b), w.splat(self.0[3])];
            (all.map(|x| w.store(x)), w.le(a, b))
        }
    }

    #[test]
    fn avx2_and_scalar_code_return_equal_bits() {
        let values = [0.0, -0.0, 1.5, -2.25e-30, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, 3e38];
        for turn in 0..8 {
            let mut other = values;
            other.rotate_left(turn);
            let bits = |m: F32x8Dispatch| {
                let (all, le) = m.run(AllOperations(values, other));
                // IEEE 754 does not specify which NaN of several is returned.
                (all.map(|x| x.map(|x| if x.is_nan() { 0 } else { x.to_bits() })), le)
            };
            assert_eq!(bits(F32x8Dispatch::detect()), bits(F32x8Dispatch::scalar()), "{turn}");
        }
        assert_eq!(F32x8Dispatch::scalar().run(AllOperations(values, [1.0; 8])).1, 0b0100_1011);
    }
}
