//! Exchange between clusters of zones: a hierarchical matrix of links (hierarchical radiosity of clusters, Sillion; zoning of Hottel &
//! Sarofim at the leaves).
//!
//! | module | contents |
//! |---|---|
//! | [`tree`], [`tree_construction`], [`node_moments`] | the tree of clusters, its construction, the moments of its nodes |
//! | [`kernel`] | the kernel between two clusters to second order |
//! | [`near_field`] | the mean kernel of clusters close to each other |
//! | [`cluster_visibility`] | visibility and attenuation between clusters, by rays |
//! | [`error_budget`] | power and tolerance of every node from an approximate solution |
//! | [`pair_kernel`] | the kernel of a pair and the error of its expansion |
//! | [`refinement`] | the choice of the pairs that become links |
//! | [`links`] | links and their application: upward, across, downward |
//! | [`link_error`] | the error that the links leave in a solution |
//!
//! No module here depends on the rays of [`crate::ray`].

pub(crate) mod cluster_visibility;
pub(crate) mod error_budget;
pub(crate) mod kernel;
pub(crate) mod link_error;
pub(crate) mod links;
mod near_field;
mod node_moments;
pub(crate) mod pair_kernel;
pub(crate) mod refinement;
mod refinement_params;
pub(crate) mod tree;
mod tree_construction;
