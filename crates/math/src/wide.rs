//! Eight single-precision numbers side by side, with comparisons as bits: for trees of boxes.
//!
//! A [`Task`] is compiled twice, for AVX2 and for plain arrays, and [`Machine::run`] takes what the machine has. Each operation is
//! one of IEEE 754 and none is contracted, so that the bits are the same on every machine.

/// A number in each of eight lanes.
pub type Lanes = [f32; 8];

/// The operations. `min(a, b)` is `a` where a < b, else `b`; `max(a, b)` is `a` where a > b, else `b`.
pub trait Wide: Copy {
    /// Eight numbers in a register.
    type F: Copy;
    /// The same number in each lane.
    fn splat(self, x: f32) -> Self::F;
    /// Numbers from memory.
    fn load(self, x: &Lanes) -> Self::F;
    /// Numbers to memory.
    fn store(self, x: Self::F) -> Lanes;
    /// a + b
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a − b
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// The smaller one.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger one.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Bit l is set where a ≤ b in lane l.
    fn le(self, a: Self::F, b: Self::F) -> u32;
}

/// Work on eight lanes at a time; mark `go`, and what it calls, `#[inline(always)]`.
pub trait Task {
    /// What it makes.
    type Output;
    /// Does it.
    fn go<W: Wide>(self, wide: W) -> Self::Output;
}

/// What the machine has, asked once.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    #[cfg(target_arch = "x86_64")]
    avx2: Option<pulp::x86::V3>,
}

impl Machine {
    /// Asks the machine.
    pub fn detect() -> Machine {
        Machine {
            #[cfg(target_arch = "x86_64")]
            avx2: pulp::x86::V3::try_new(),
        }
    }
    /// A machine without vector instructions, for comparison.
    pub fn plain() -> Machine {
        Machine {
            #[cfg(target_arch = "x86_64")]
            avx2: None,
        }
    }
    /// Does the work.
    #[inline(always)]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = self.avx2 {
            return v3.vectorize(Call { v3, task });
        }
        task.go(Plain)
    }
}

#[cfg(target_arch = "x86_64")]
struct Call<T> {
    v3: pulp::x86::V3,
    task: T,
}

#[cfg(target_arch = "x86_64")]
impl<T: Task> pulp::NullaryFnOnce for Call<T> {
    type Output = T::Output;
    #[inline(always)]
    fn call(self) -> T::Output {
        self.task.go(self.v3)
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Lanes, Wide};
    use pulp::bytemuck::cast;
    use pulp::x86::V3;
    use std::arch::x86_64::{__m256, _CMP_LE_OQ};

    impl Wide for V3 {
        type F = __m256;
        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            self.avx._mm256_set1_ps(x)
        }
        #[inline(always)]
        fn load(self, x: &Lanes) -> __m256 {
            cast(*x)
        }
        #[inline(always)]
        fn store(self, x: __m256) -> Lanes {
            cast(x)
        }
        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_mul_ps(a, b)
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_min_ps(a, b)
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            self.avx._mm256_max_ps(a, b)
        }
        #[inline(always)]
        fn le(self, a: __m256, b: __m256) -> u32 {
            let mask = self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
            self.avx._mm256_movemask_ps(mask) as u32
        }
    }
}

/// Arrays; the compiler makes what it can of them.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

#[inline(always)]
fn each(a: Lanes, b: Lanes, f: impl Fn(f32, f32) -> f32) -> Lanes {
    std::array::from_fn(|l| f(a[l], b[l]))
}

impl Wide for Plain {
    type F = Lanes;
    #[inline(always)]
    fn splat(self, x: f32) -> Lanes {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, x: &Lanes) -> Lanes {
        *x
    }
    #[inline(always)]
    fn store(self, x: Lanes) -> Lanes {
        x
    }
    #[inline(always)]
    fn add(self, a: Lanes, b: Lanes) -> Lanes {
        each(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: Lanes, b: Lanes) -> Lanes {
        each(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: Lanes, b: Lanes) -> Lanes {
        each(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn min(self, a: Lanes, b: Lanes) -> Lanes {
        each(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: Lanes, b: Lanes) -> Lanes {
        each(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, a: Lanes, b: Lanes) -> u32 {
        (0..8).fold(0, |m, l| m | u32::from(a[l] <= b[l]) << l)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct All(Lanes, Lanes);

    impl Task for All {
        type Output = ([Lanes; 6], u32);
        #[inline(always)]
        fn go<W: Wide>(self, w: W) -> Self::Output {
            let (a, b) = (w.load(&self.0), w.load(&self.1));
            let all = [w.add(a, b), w.sub(a, b), w.mul(a, b), w.min(a, b), w.max(a, b), w.splat(self.0[3])];
            (all.map(|x| w.store(x)), w.le(a, b))
        }
    }

    #[test]
    fn every_machine_gives_the_same_bits() {
        let values = [0.0, -0.0, 1.5, -2.25e-30, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, 3e38];
        for turn in 0..8 {
            let mut other = values;
            other.rotate_left(turn);
            let bits = |m: Machine| {
                let (all, le) = m.run(All(values, other));
                // Which of several numbers that are none comes out is not said.
                (all.map(|x| x.map(|x| if x.is_nan() { 0 } else { x.to_bits() })), le)
            };
            assert_eq!(bits(Machine::detect()), bits(Machine::plain()), "{turn}");
        }
        assert_eq!(Machine::plain().run(All(values, [1.0; 8])).1, 0b0100_1011);
    }
}
