//! Sample counts and limits of shadow rays. Pairs of values are those of patches and of volume zones.

/// Wanted error over tolerance and root mean square of the light. The errors of volume zones average out along any path.
pub(crate) const ERROR_SHARE: [f64; 2] = [0.35, 0.45];
/// For zones with less light the wanted error falls with their light, down to this share.
pub(super) const MIN_RELATIVE_LEVEL: [f64; 2] = [0.25, 0.7];

/// Pilot samples of a zone.
pub(super) const PILOT_SAMPLES: [usize; 2] = [8, 4];
/// Minimum number of further samples of a zone; all numbers are multiples of it.
pub(super) const SAMPLE_QUANTUM: usize = 16;
/// Maximum number of samples of a zone at tolerances from [`FINE_TOLERANCE`]; the rest of a voxel's error averages out along any path.
pub(super) const MAX_SAMPLES: [usize; 2] = [768, 384];
/// Error over the wanted one beyond which a zone among obstacles is sampled a third time: the number of its second samples follows from a few pilot samples.
pub(super) const MAX_ERROR_EXCESS: f64 = 2.0;
/// Least number of the first fresh sample of a zone, after its pilot samples. More samples than this begin at a power of two that is not less than
/// their number, so that aligned blocks of the sequence are nets.
pub(super) const FIRST_FRESH_SAMPLE: usize = 256;
/// Tolerance below which the maximum grows as the error requires, up to [`MAX_SAMPLES_PER_ZONE`] and [`MAX_RAYS`].
pub(super) const FINE_TOLERANCE: f64 = 0.1;
pub(super) const MAX_SAMPLES_PER_ZONE: usize = 1 << 14;
/// Maximum number of shadow rays of one light to all zones together.
pub(super) const MAX_RAYS: usize = 1 << 26;

/// Maximum number of rays of a zone through openings.
pub(super) const MAX_OPENING_RAYS: usize = 1 << 15;

/// Number of samples beyond which the error of samples that disagree falls like the number to the power −[`FOUR_DIMENSIONAL_RATE`].
pub(super) const FOUR_DIMENSIONAL_SAMPLES: f64 = 256.0;
pub(super) const FOUR_DIMENSIONAL_RATE: f64 = 0.625;
/// Exponent of the visible fraction of a sky, and the least fraction, for the growth of its error behind small openings; of a uniform sky the fraction below which it grows.
pub(super) const SMALL_OPENING_RATE: f64 = 1.0 / 6.0;
pub(super) const MIN_VISIBLE_FRACTION: f64 = 1e-4;
pub(super) const SMALL_VISIBLE_FRACTION: f64 = 0.25;
/// Stated error over the formula in the module header, which holds in the mean: behind obstacles close to a lamp it is up to two thirds too small.
pub(super) const STATED_OVER_MEAN_ERROR: f64 = 1.8;
/// The same for samples that all agree.
pub(super) const STATED_OVER_AGREEMENT_ERROR: f64 = 1.5;

/// Samples of a voxel whose ratio is averaged with those around it.
pub(super) const AVERAGED_VOXEL_SAMPLES: usize = 16;
/// Largest deviation of a cell's ratio from the mean of the 27 cells, in multiples of its own error.
pub(super) const MAX_DEVIATION_FROM_MEAN: f64 = 3.0;
/// Largest change of the ratio from one side of the 27 cells to the other.
pub(super) const MAX_RATIO_CHANGE: f64 = 0.12;
/// Error of a mean over 27 cells: this share of that change, and the next one of the cell's own error.
pub(super) const CURVATURE_SHARE: f64 = 0.1;
pub(super) const AVERAGED_ERROR_SHARE: f64 = 0.25;

/// Pilot points of a pane, and samples of the light at each.
pub(super) const PANE_POINTS: usize = 16;
pub(super) const SAMPLES_PER_PANE_POINT: usize = 2;
/// Largest growth of the number of points, and parts whose spread gives the error.
pub(super) const MAX_PANE_GROWTH: usize = 64;
pub(super) const PANE_PARTS: usize = 8;

/// Distance in cells over which pilot samples are compared: a fraction of the light that all of them miss is negligible.
pub(super) const AGREEMENT_REACH: usize = 2;
/// Most patches of the smallest clusters, whose samples are compared where there is no voxel grid, and of the largest that support one another.
pub(super) const PATCHES_PER_CLUSTER: usize = 16;
pub(super) const MAX_PATCHES_PER_CLUSTER: usize = 256;
/// Share of the zones with agreeing pilot samples whose neighbours disagree; for the expected number of rays.
pub(super) const DISAGREEING_NEIGHBOURS: f64 = 0.5;
/// Samples of a patch whose cluster agrees over those that it needs alone; for the expected number of rays.
pub(super) const EXPECTED_CLUSTER_SHARE: f64 = 0.3;
/// Zones of a part of a sum.
pub(super) const CHUNK_ZONES: usize = 256;
/// Zones of a task: zones differ by their number of samples.
pub(super) const ZONES_PER_TASK: usize = 32;
