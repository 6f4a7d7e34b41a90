//! Dispatch of loops over arrays to the widest vector instructions of the processor.
//!
//! [`dispatch`] and [`run`] compile a computation for AVX-512, AVX2 and the baseline instruction set (crate pulp) and run the best version
//! that the processor supports. The compiler vectorises loops over arrays of [`LANES`] numbers. It never contracts a·b + c and never
//! reorders sums, so that **all processors return the same bits**. Computations must not use `mul_add`: without the instruction it is a
//! slow library call.

/// Length of a lane array: the double-precision numbers in one AVX-512 register, or in two of AVX2.
pub const LANES: usize = 8;

/// Runs a closure with the best instructions of the processor. Functions that it calls are vectorised only if they are `#[inline(always)]`.
///
/// ```
/// let x = [0.5; zonal_math::simd::LANES];
/// assert_eq!(zonal_math::simd::dispatch(|| x.map(|v| 2.0 * v)), [1.0; zonal_math::simd::LANES]);
/// ```
#[inline(always)]
pub fn dispatch<R>(computation: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(computation)
}

/// A computation for [`run`]; `evaluate` must be `#[inline(always)]`.
pub trait SimdKernel {
    /// The result.
    type Output;
    /// Runs the computation.
    fn evaluate(self) -> Self::Output;
}

struct KernelCall<K>(K);

impl<K: SimdKernel> pulp::NullaryFnOnce for KernelCall<K> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.evaluate()
    }
}

/// As [`dispatch`], for loops of any length: the compiler may leave a large **closure** outside the function that has the vector
/// instructions, but never a [`SimdKernel`].
#[inline(always)]
pub fn run<K: SimdKernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(KernelCall(kernel))
}
