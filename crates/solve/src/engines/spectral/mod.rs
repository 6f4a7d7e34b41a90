//! The spectral engine: all exchange areas of a box enclosure, each to a proven tolerance, with memory proportional to the number of zones.
//!
//! In a box on a regular grid with one extinction κ, the exchange factor of two zones depends on their offset alone: the exchange of all
//! zones is a convolution, computed by fast Fourier transforms. For n zones one product costs n log n operations instead of n² for all pairs:
//! 115³ voxels and their walls have 2.7·10¹² exchange areas.
//!
//! | module | content |
//! |---|---|
//! | [`enclosure`] | where the engine applies, and why not |
//! | `kernels` | tables by offset, and their spectra |
//! | `real_symmetric_fft` | transforms of even and odd sequences: kernels to real spectra |
//! | `spectral_operator` | the operator: bands, unknowns and errors; products on a [`crate::device::Device`] |
//! | `box_in_blocks` | the box with cells of longer edges, for the correction of the iteration |
//! | [`cpu`] | the processor as this device: transforms, product in frequency space, planes of each process, walls |
//! | `buffer_pool` | buffers of products at the same time |
//! | `memory` | memory of the spectra and of a product, bytes of messages |
//!
//! Grid, basis, spectra and division among processes stand in [`crate::device`], with the convolution theorem and the cost of a product.
//!
//! **Thick zones.** A radiosity that is constant in a voxel transmits too much light if κℓ is not small: the diffusion limit is wrong. A linear basis
//! ([`crate::device::basis`]) has the correct limit, in slabs of any thickness, and its error is of higher order in ℓ. Beside edges where walls of
//! different radiosity meet, the light decays within a mean free path, which the voxels have to resolve. The unknowns are the constants of all zones,
//! then the slopes of the patches along their first and second axis, then those of the voxels along x, y, z. Products of the constants alone have
//! slopes of zero.
//!
//! **Error.** Every factor has a proven relative radius (`kernels::TOLERANCE`), with all images of periodic axes; with slopes an estimated one
//! (`kernels::LINEAR_TOLERANCE`). The closure defect of the worst row in a uniform field, of zones or slopes, is measured and counts as a fraction of the
//! incident power. Rounding of the transforms: about ε √log₂N times the root mean square over all zones, which is large only compared with
//! zones that receive almost nothing. The grade of the whole is therefore estimated.

pub(crate) mod box_in_blocks;
pub(crate) mod buffer_pool;
pub mod cpu;
pub mod enclosure;
pub(crate) mod kernels;
mod memory;
pub(crate) mod real_symmetric_fft;
pub(crate) mod spectral_operator;

pub(crate) use memory::sent_bytes_of_product;
pub use spectral_operator::SpectralOperator;
