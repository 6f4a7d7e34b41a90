use super::*;
use crate::aligned::{Cuboid, geometric_factor};
use zonal_math::vec3;

#[test]
fn counts_of_distinct_offsets() {
    assert_eq!(Index::of_edges([1.0; 3], [115; 3]).offsets().len(), 260_130);
}
