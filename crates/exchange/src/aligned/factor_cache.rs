//! Cache of factors by the canonical geometry of a pair: the pairs of a grid are few up to the symmetries of the axes.
//!
//! **Key.** A factor depends, axis by axis, on the two extents **unordered** (the trapezoid is symmetric in them) and on the
//! centre offset up to its sign (with a flat box on the axis: its sign relative to the normal), and on the axes in any
//! order. So the key holds, sorted: long/L, short/long, low/long per axis, with L the longest extent of all and `low` the least
//! t (the gap between the boxes, negative where they overlap), and L and κ. L and the ratios are rounded to 42 bits, low/long to
//! multiples of 2⁻⁴¹ (4.5e-13): lattice offsets are exact there, the roundings of their coordinates vanish, and boxes that touch
//! or are flush within 2⁻³⁸ (3.6e-12) of the longer edge do so exactly.
//!
//! **Value.** The factor belongs to the geometry of the key, with breakpoints within an ulp or two:
//! results do not depend on the order of threads, and F(a, b) = F(b, a) to the bit. The radius refers to that geometry: its lengths
//! are within 2⁻³⁸ (relative to the longer extent of their axis) of the requested ones, mostly within 2⁻⁴².

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};
use std::sync::Mutex;

use super::cell_integration;
use super::cuboid::Cuboid;
use super::method_selection::{FINEST_TOLERANCE, factor_of};
use super::reduced_pair::{AxisDensity, ReducedPair, orientation};
use zonal_math::Bounded;

/// The factor without attenuation and the first cumulants of the distance under its kernel, for media whose
/// extinction varies: 𝓕_κ ≈ 𝓕₀ exp(−κ r̄ + κ² var/2 − κ³ third/6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceCumulants {
    /// The factor at κ = 0, proved.
    pub factor: Bounded,
    /// Mean distance ⟨r⟩, m, to about the factor's relative accuracy (zero for a pair that is not visible).
    pub mean_distance: f64,
    /// Variance ⟨(r − r̄)²⟩, m².
    pub variance: f64,
    /// Third cumulant ⟨(r − r̄)³⟩, m³.
    pub third_cumulant: f64,
    /// Fourth cumulant ⟨(r − r̄)⁴⟩ − 3 var², m⁴.
    pub fourth_cumulant: f64,
}

impl DistanceCumulants {
    const NOT_VISIBLE: DistanceCumulants = DistanceCumulants {
        factor: Bounded::ZERO,
        mean_distance: 0.0,
        variance: 0.0,
        third_cumulant: 0.0,
        fourth_cumulant: 0.0,
    };
}

/// The canonical form of a pair and an extinction: [L, κ, then (long/L, short/long, low/long) for each axis].
#[derive(Clone, Copy, PartialEq, Eq)]
struct CanonicalKey {
    words: [u64; 11],
    hash: u64,
}

impl Hash for CanonicalKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.hash);
    }
}

/// Hasher that returns the hash stored in the key.
#[derive(Default)]
struct IdentityHasher(u64);

impl Hasher for IdentityHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.0 = self.0.rotate_left(8) ^ b as u64;
        }
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = x;
    }
}

type Shard<V> = Mutex<HashMap<CanonicalKey, V, BuildHasherDefault<IdentityHasher>>>;

const SHARD_COUNT: usize = 64;

/// A hash table divided into shards, each with a lock.
struct ShardedTable<V>(Vec<Shard<V>>);

impl<V: Copy> ShardedTable<V> {
    fn new() -> ShardedTable<V> {
        ShardedTable((0..SHARD_COUNT).map(|_| Mutex::default()).collect())
    }

    /// The stored value, or that of `compute`, evaluated outside the lock; the value does not depend on which thread is first.
    fn get(&self, key: &CanonicalKey, compute: impl FnOnce() -> V) -> V {
        let shard = &self.0[(key.hash >> 32) as usize % SHARD_COUNT];
        if let Some(v) = lock(shard).get(key) {
            return *v;
        }
        let v = compute();
        lock(shard).insert(*key, v);
        v
    }

    fn len(&self) -> usize {
        self.0.iter().map(|s| lock(s).len()).sum()
    }
}

fn lock<T>(m: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    m.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// A thread-safe cache of factors and cumulants at one tolerance.
pub struct FactorCache {
    tolerance: f64,
    factors: ShardedTable<Bounded>,
    cumulants: ShardedTable<DistanceCumulants>,
}

impl FactorCache {
    /// An empty cache whose factors have radius ≤ `tolerance` · value (see [`super::geometric_factor`]).
    ///
    /// # Panics
    /// On a tolerance that is not positive.
    pub fn new(tolerance: f64) -> FactorCache {
        assert!(tolerance > 0.0, "tolerance {tolerance}");
        FactorCache { tolerance, factors: ShardedTable::new(), cumulants: ShardedTable::new() }
    }

    /// Number of stored factors.
    pub fn len(&self) -> usize {
        self.factors.len()
    }

    /// True if no factor is stored.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The geometric factor of a pair for extinction `kappa` ≥ 0 (1/m); boxes must be valid ([`Cuboid::is_valid`]).
    pub fn get(&self, a: &Cuboid, b: &Cuboid, kappa: f64) -> Bounded {
        debug_assert!(a.is_valid() && b.is_valid() && kappa >= 0.0, "{a:?} {b:?} {kappa}");
        match canonical_key(a, b, kappa) {
            None => Bounded::ZERO,
            Some(k) => self.factors.get(&k, || factor_of(&pair_of_key(&k), kappa, self.tolerance).bounded),
        }
    }

    /// The factor at κ = 0 with the cumulants of the distance.
    pub fn get_cumulants(&self, a: &Cuboid, b: &Cuboid) -> DistanceCumulants {
        debug_assert!(a.is_valid() && b.is_valid(), "{a:?} {b:?}");
        match canonical_key(a, b, 0.0) {
            None => DistanceCumulants::NOT_VISIBLE,
            Some(k) => self.cumulants.get(&k, || cumulants_of(&pair_of_key(&k), self.tolerance)),
        }
    }
}

fn cumulants_of(pair: &ReducedPair, tolerance: f64) -> DistanceCumulants {
    let i = cell_integration::integrate::<5>(pair, 0.0, tolerance.clamp(FINEST_TOLERANCE, 0.1));
    // Moments of r − r₀, r₀ the least distance: no digits lost for far pairs.
    let [m1, m2, m3, m4] = [1, 2, 3, 4].map(|p| i.value[p] / i.value[0]);
    let v = (m2 - m1 * m1).max(0.0);
    let third = m3 - m1 * (3.0 * m2 - 2.0 * m1 * m1);
    let fourth_central = m4 - m1 * (4.0 * m3 - m1 * (6.0 * m2 - 3.0 * m1 * m1));
    DistanceCumulants {
        factor: Bounded::proved(i.value[0], i.radius),
        mean_distance: i.nearest + m1,
        variance: v,
        third_cumulant: third,
        fourth_cumulant: fourth_central - 3.0 * v * v,
    }
}

/// 1.5 · 2¹¹: adding and subtracting it rounds to a multiple of 2⁻⁴¹.
const LATTICE_ROUNDER: f64 = 3072.0;

/// The nearest multiple of 2⁻⁴¹ (of a few ulp beyond a thousand), never −0.
fn round_to_lattice(x: f64) -> f64 {
    (x + LATTICE_ROUNDER) - LATTICE_ROUNDER + 0.0
}

/// A positive number to 42 significant bits.
fn round_to_42_bits(x: f64) -> f64 {
    const DROPPED_BITS: u32 = 11;
    f64::from_bits((x.to_bits() + (1 << (DROPPED_BITS - 1))) & !((1 << DROPPED_BITS) - 1))
}

/// The canonical key; `None` when the boxes are not visible from each other.
fn canonical_key(a: &Cuboid, b: &Cuboid, kappa: f64) -> Option<CanonicalKey> {
    let sign = orientation(a.normal, b.normal)?;
    let (ea, eb) = (a.extent().array(), b.extent().array());
    let long: [f64; 3] = std::array::from_fn(|k| ea[k].max(eb[k]));
    let scale = long[0].max(long[1]).max(long[2]);
    let per_scale = 1.0 / scale;
    let mut axes = [[0u64; 3]; 3];
    for k in 0..3 {
        // Antisymmetric in a and b to the bit.
        let offset = 0.5 * ((b.lo[k] + b.hi[k]) - (a.lo[k] + a.hi[k]));
        let towards = match sign[k] {
            0 => offset.abs(),
            s => offset * s as f64,
        };
        let [short, low] = normalized_axis(long[k], ea[k].min(eb[k]), per_scale, towards);
        // The upper end of t: the pair is not visible unless it is positive.
        let width = if long[k] == 0.0 { 0.0 } else { 1.0 };
        if sign[k] != 0 && low + width <= 0.0 {
            return None;
        }
        axes[k] = [round_to_42_bits(long[k] * per_scale), short, low].map(f64::to_bits);
    }
    sort(&mut axes);
    let mut words = [0; 11];
    (words[0], words[1]) = (round_to_42_bits(scale).to_bits(), kappa.to_bits());
    for k in 0..3 {
        words[2 + 3 * k..5 + 3 * k].copy_from_slice(&axes[k]);
    }
    Some(CanonicalKey { words, hash: hash_words(&words) })
}

/// (short/long, low/long), rounded; where both boxes are flat (0, offset/scale).
fn normalized_axis(long: f64, short: f64, per_scale: f64, offset: f64) -> [f64; 2] {
    if long == 0.0 {
        return [0.0, round_to_lattice(offset * per_scale)];
    }
    let per_long = 1.0 / long;
    let short = round_to_42_bits(short * per_long);
    let half = 0.5 * (1.0 + short);
    let low = offset * per_long - half;
    let low = if offset.abs() < CONTACT_TOLERANCE * long {
        -half
    } else if low.abs() < CONTACT_TOLERANCE {
        0.0
    } else if (low + short).abs() < CONTACT_TOLERANCE {
        -short
    } else {
        round_to_lattice(low)
    };
    [short, low + 0.0]
}

/// 2⁻³⁸: boxes nearer than this (relative to the longer edge) touch; faces are flush.
const CONTACT_TOLERANCE: f64 = 1.0 / (1u64 << 38) as f64;

/// Sorts three axes by three comparisons.
fn sort(axes: &mut [[u64; 3]; 3]) {
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if axes[i] > axes[j] {
            axes.swap(i, j);
        }
    }
}

/// A multilinear hash of the words with a final mix. High halves are folded down first, since lattices leave the low bits zero.
fn hash_words(words: &[u64; 11]) -> u64 {
    let lane = |(i, w): (usize, &u64)| {
        (w ^ (w >> 29)).wrapping_mul(GOLDEN_MULTIPLIER.wrapping_mul(2 * i as u64 + 3))
    };
    let h = words.iter().enumerate().map(lane).fold(0, u64::wrapping_add);
    let h = (h ^ (h >> 32)).wrapping_mul(0x94D0_49BB_1331_11EB);
    let h = (h ^ (h >> 31)).wrapping_mul(GOLDEN_MULTIPLIER);
    h ^ (h >> 29)
}

/// 2⁶⁴ over the golden ratio, odd.
const GOLDEN_MULTIPLIER: u64 = 0x9E37_79B9_7F4A_7C15;

/// The geometry of a key. Breakpoints are computed in units of the axis, where lattices are exact.
fn pair_of_key(key: &CanonicalKey) -> ReducedPair {
    let w = key.words.map(f64::from_bits);
    let scale = w[0];
    ReducedPair(std::array::from_fn(|k| {
        let (ratio, short, low) = (w[2 + 3 * k], w[3 + 3 * k], w[4 + 3 * k]);
        let long = ratio * scale;
        let p = if long == 0.0 {
            [low * scale; 4]
        } else {
            [low, low + short, low + 1.0, low + 1.0 + short].map(|t| t * long)
        };
        AxisDensity { long, short: short * long, p }
    }))
}
