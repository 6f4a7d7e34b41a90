//! Parameters of the refinement.

/// Errors that links may leave, and the effort spent on a pair.
///
/// The **significance** of a pair is the power that it carries over the tolerance at its receiver, the larger of both directions.
///
/// Errors and costs with these values: `cargo run --release --example against_dense -- c0 c9 c8 random1 random2 demo cornell --dense 0.003`;
/// L2 error at most 0.85 of the tolerance, estimate 1.9 to 7.7 times the error in the median (`docs/hierarchical.md`).
pub(crate) struct RefinementParams {
    /// β: share of the tolerance that the sampling of visibility may take.
    pub visibility_sampling_share: f64,
    /// γ: share of the tolerance that unresolved variation of visibility may take.
    pub visibility_variation_share: f64,
    /// Significance below which no pair is split for partial occlusion: √(v(1 − v)) is at most a half.
    pub min_significance_for_visibility_split: f64,
    /// v(1 − v) of a pair of zones that may be partly occluded.
    pub typical_visibility_variance: f64,
    /// Demanded error of visibility below which the test that nothing can occlude the pair pays.
    pub max_visibility_error_for_shaft_test: f64,
    /// Demanded error of visibility below which a pair of zones is computed as the dense engine does.
    pub max_visibility_error_for_pair_factor: f64,
    /// Rays from which on the visible fraction multiplies the mean kernel; fewer give the mean of the product.
    pub min_rays_for_visible_fraction: usize,
    /// Relative error of a pair of voxel clusters of zeroth order, whose mean kernel is exact.
    pub zeroth_order_error: f64,
    /// Relative error where a plane of one cluster cuts the other, or the mean kernel is a guess.
    pub cut_pair_error: f64,
    /// Share of the variation of the source that counts.
    pub source_variation_share: f64,
    /// Variation q above which two zones have their exact geometric factor in place of the second-order mean.
    pub max_variation_of_zones: f64,
    /// Variation q above which the mean over two boxes is taken from their exact factor.
    pub max_variation_of_boxes: f64,
    /// Relative radius of the geometric factors of zones.
    pub zone_factor_tolerance: f64,
    /// Significance of two near patches, or cut voxels, above which their factor is computed in full.
    pub min_significance_for_full_factor: f64,
    /// Significance above which the attenuation by a varying medium is a mean over points, not that between the centroids.
    pub min_significance_for_sampled_medium: f64,
    /// Cosine that represents all directions through a pane where a pair has no direction.
    pub mean_pane_cosine: f64,
    /// Points in a voxel for the mean solid angle of a near patch.
    pub near_points: usize,
    /// Most points over `near_points`, for significant pairs.
    pub max_near_points_factor: usize,
    /// Most points of the mean kernel of a pair of zeroth order.
    pub max_kernel_points: usize,
    /// Most rays of a link.
    pub max_rays_per_link: usize,
}

/// The values in use.
pub(crate) const REFINEMENT_PARAMS: RefinementParams = RefinementParams {
    visibility_sampling_share: 1.0,
    visibility_variation_share: 1.0,
    min_significance_for_visibility_split: 2.0,
    typical_visibility_variance: 0.1,
    max_visibility_error_for_shaft_test: 0.3,
    max_visibility_error_for_pair_factor: 0.02,
    min_rays_for_visible_fraction: 8,
    zeroth_order_error: 0.3,
    cut_pair_error: 0.6,
    source_variation_share: 0.3,
    max_variation_of_zones: 0.04,
    max_variation_of_boxes: 0.01,
    zone_factor_tolerance: 2e-3,
    min_significance_for_full_factor: 8.0,
    min_significance_for_sampled_medium: 0.1,
    mean_pane_cosine: 0.5,
    near_points: 12,
    max_near_points_factor: 4,
    max_kernel_points: 8,
    max_rays_per_link: 128,
};
