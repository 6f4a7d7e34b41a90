//! Direct light on all zones by shadow rays, with an adaptive number of samples.
//!
//! Each sample joins a point x of the zone with a point of the light. With w its contribution without occlusion, τ the transmittance of medium and
//! panes (0 behind a facet) and U the unoccluded light (in closed form if there is one, else ⟨w⟩), the estimate is the ratio estimator
//!
//! ```text
//! H or G = ⟨U(x)⟩ R      R = Σ w τ / Σ w
//! ```
//!
//! so that a fully lit zone has no noise but that of τ. Points of an emitter are sampled by solid angle: w is bounded, and the fraction of visible
//! samples is the fraction of visible light, also beside the emitter. Points of the light and of the zone are one scrambled Sobol sequence in six
//! dimensions. The error of the visible fraction s of m samples is about
//!
//! ```text
//! e = √(s(1−s)) m^(−3/4)     if the samples disagree (the shadow boundary runs through few of m strata);
//!                            beyond 256 samples like m^(−5/8): points and directions have four dimensions
//!                            below a sky times s^(−1/6), of a uniform one min(1, 4s)^(−1/6), for openings narrower than the strata;
//!                            below one that is not uniform with m/2 on a patch: one half of its samples is cosine-weighted, the other by radiance
//! e = ½/(m+1)                if all agree, with m counted over the zone and the 124 cells around it (25 of them for a patch)
//! e = ½√K/(N+1)              if all N samples of the K patches of a cluster agree and there are no cells (`patch_clusters`)
//! ```
//!
//! Where no sample brings light even without occlusion, U is an upper bound of the light (`LightSampler::upper_bound`), which is zero only where the light is proved to be
//! behind the zone; R is 0 and e that of agreeing samples.
//!
//! Every zone gets a few pilot samples, then fresh ones where U e exceeds a share of the tolerance times the root mean square of the light over the
//! zones of its kind. Their number follows from the pilot samples, within limits that grow for small tolerances; a zone among obstacles whose error
//! is still too large is sampled a third time. In cells without obstacles the ratios R of a cell and the 26 around it are averaged if the ratio of
//! the cell agrees with the mean within its error: a penumbra is wider than a cell unless the light is a sun. Zones that need
//! thousands of samples of a sky see it through small openings: these are found by rays and become strata of points (`surroundings/sky_openings`), unless the sky has a peak
//! such as the sun of a picture. All random numbers are functions of zone and sample index.
//!
//! | module | content |
//! |---|---|
//! | `params` | sample counts and limits |
//! | `zone_sampler` | samples of one zone and their statistics |
//! | `point_light` | samples of a point light on one zone |
//! | `pane_sampler` | panes |
//! | `neighbour_agreement` | pilot samples of the cells around a zone |
//! | `patch_clusters` | samples of the patches around a patch, in scenes without cells |
//! | `gather` | all zones, and the expected number of rays |

mod gather;
mod neighbour_agreement;
mod pane_sampler;
mod params;
mod patch_clusters;
mod point_light;
mod zone_sampler;

pub(crate) use gather::{GatheredLight, expected_rays, gather};
pub(crate) use params::ERROR_SHARE;

#[cfg(test)]
mod tests;
