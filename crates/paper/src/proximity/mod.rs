//! A near-field series expansion (section 3.1 of the paper, the “proximity development”): factors of a patch B and all cells of the mesh of a
//! smooth surface, from a few reference points.
//!
//! ```text
//! 𝓕(B, A) = ∫_B ∫_A K du dv dy,   K = (m·d)(−N·d)/(π (d·d)²),   d = S(u, v) − y,   N = S_u × S_v (to the front),
//! ```
//!
//! m the unit normal of B. About a reference (u₀, v₀), u = u₀ + Xξ, v = v₀ + Zζ, everything is a power series in ξ, ζ, truncated at total degree N:
//! S − S₀ from the surface's local form (`surface`), ρ = d·d = |y′|² − 2y′·(S − S₀) + |S − S₀|² with y′ = y − S₀, ρ⁻² by recurrence (`power_series`).
//! m·d does not depend on y, and N·d = N·(S − S₀) − N·y′, so a node y of the rule over B costs one recurrence and four sums,
//!
//! ```text
//! G = Σ w ρ⁻²,  G′ = Σ w y′ρ⁻²,   Σ w K = (m·d)(N·G′ − N·(S − S₀) G)/π,
//! ```
//!
//! whatever the number of cells; a cell costs (N+1)(N+2)/2 products with the exact integrals of ξ^pζ^q. On a plane, along a line, this is
//! the paper's strip with the Gegenbauer polynomials of λ = 2.
//!
//! **Truncation.** Let W bound |S − S₀| and M bound |K| on the polydisc |ξ|, |ζ| ≤ s. At a point with max(|ξ|, |ζ|) ≤ τ < s the function
//! λ ↦ K(λξ, λζ) is analytic and at most M for |λ| ≤ s/τ, so (Cauchy) the terms of degree above N are at most M θ^{N+1}/(1 − θ), θ = τ/s.
//! Let D = |y′| be least over B, and W = W₁ + W₂ with W₁ for the linear part of S − S₀, λ times a real vector, and W₂ for the rest. As for a plane, the
//! linear part alone leaves |d·d| ≥ (D − W₁)² (its zeros have |λ||w| = |d₀|), so **|d·d| ≥ (D − W₁)² − 2(D + W₁)W₂ − W₂²**. Or, with d = a + ib,
//! |d·d| ≥ a² − b² and |a − d₀|² + b² ≤ W² give **|d·d| ≥ (D − W)²** for W ≤ D/2 (the least of a² − b² is then at b = 0). The larger holds. Also
//! |m·d| ≤ |m·d₀| + W and |N·d| ≤ |N₀·d₀| + ΔN(|d₀| + W) + |N₀|W₂, as N₀ is normal to the linear part. M is their quotient. For each cell
//! the s with the smallest bound is taken from `POLYDISC_SCALES`.
//!
//! **Quadrature** over B, Gauss–Legendre in two directions (by the Duffy transform on a triangle). Let y move along its plane by the complex
//! multiple c f of an edge, |c f| ≤ δ < D′, D′ the least and D″ the largest real distance. d·d has its zeros at complex multiples of modulus
//! |d|/|f|, so |d·d| ≥ (|d| − δ)²; m·d does not change. On the ellipse of semi-axes a, b about the edge the distance to the edge is at most b|f|/2 = δ. So M′ = (m·d)^ N̂ (D″ + δ)/(π (D′ − δ)⁴), times 1 + a for the weight of a triangle.
//!
//! **Rounding**: norms of the series (`power_series`) bound every product; the error of S₀ and of the nodes enters ρ, m·d and N·d.
//! Library sines and cosines are assumed accurate to an ulp.
//!
//! **References**: a block of cells has one, in its middle, if the bound for the whole block is within the tolerance; else the block is
//! halved across its longer extent. A single cell that fails is too near: it has a large radius or is [`CellFactor::Near`].
//! **Partial visibility**: a cell must see all of B and be seen by all of it, up to rounding (a wall on the surface's
//! plane), which the radius includes. Bounds on the cell or on parts of it decide: cells entirely out of sight are
//! exactly zero; [`CellFactor::PartlyVisible`] cells are left to another method, since K changes its sign there. Other occluders are not
//! considered, nor is the surface itself where it is not convex towards B.

mod development;
mod direct_quadrature;
mod error_constants;
mod mesh;
mod plate_geometry;
mod power_series;
mod reference;
mod subdivision;
mod surface;
mod visibility;

pub use direct_quadrature::direct_integral;
pub use mesh::{CellFactor, MeshFactors, ParametricMesh};
pub use power_series::MAX_ORDER;
pub use subdivision::mesh_factors;
pub use surface::SmoothSurface;

#[cfg(test)]
mod tests;
