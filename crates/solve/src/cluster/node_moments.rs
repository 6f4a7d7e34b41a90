//! Moments of the nodes of a cluster tree: of one zone, and of a node from its children.

use super::tree::{ClusterKind, ClusterNode};
use zonal_math::Vec3;
use zonal_scene::{Plate, PlateKind, Scene, VoxelZone, Zones};

/// Relative difference between the measure of the zones and of their box below which they fill it.
const BOX_FILL_TOLERANCE: f64 = 1e-4;
/// Largest deviation of the normal component of an axis-parallel plane from one.
const AXIS_TOLERANCE: f64 = 1e-9;
/// Largest half angle between the normals of patches in one plane, rad.
const PLANE_CONE_TOLERANCE: f64 = 1e-5;
/// Largest thickness of patches in one plane, over the extent of their box.
const PLANE_THICKNESS_TOLERANCE: f64 = 1e-9;
/// Half angle that stands for normals beyond a half space, rad.
const WIDE_CONE: f64 = 4.0;

fn to_f32(v: Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// The moments of a node from those of its children, which begin at `first_child` in the tree's list.
pub(crate) fn merge_children(
    children: impl Iterator<Item = ClusterNode> + Clone,
    first_child: u32,
    child_count: u8,
) -> ClusterNode {
    // Sums of measures, centroids and normals; the common box.
    let total: f64 = children.clone().map(|k| k.measure as f64).sum();
    let share = |k: &ClusterNode| k.measure as f64 / total;
    let centre = children.clone().fold(Vec3::ZERO, |s, k| s + k.centre() * share(&k));
    let normal = children.clone().fold(Vec3::ZERO, |s, k| s + k.normal() * share(&k));
    let lo = children.clone().fold(Vec3::splat(f64::INFINITY), |s, k| s.min(k.lo));
    let hi = children.clone().fold(Vec3::splat(f64::NEG_INFINITY), |s, k| s.max(k.hi));
    // Covariance about the common centroid (parallel axis theorem).
    let mut covariance = [0.0; 6];
    for k in children.clone() {
        let d = k.centre() - centre;
        let outer = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
        (0..6).for_each(|m| covariance[m] += share(&k) * (outer[m] + k.covariance[m] as f64));
    }
    let axis = normal.normalized();
    let cone = common_cone(children.clone(), axis);
    let mut all = children.clone();
    let kind = children.clone().next().map_or(ClusterKind::Mixed, |k| k.kind);
    let same = all.all(|k| k.kind == kind);
    let fills = NodeBox { kind, lo, hi, normal: axis, cone, measure: total };
    ClusterNode {
        centre: to_f32(centre),
        lo,
        hi,
        covariance: covariance.map(|x| x as f32),
        normal: to_f32(normal),
        cone_sine: if cone < std::f64::consts::FRAC_PI_2 { cone.sin() as f32 } else { 2.0 },
        measure: total as f32,
        extinction: children.clone().map(|k| k.extinction as f64 * share(&k)).sum::<f64>() as f32,
        first_leaf: children.clone().map(|k| k.first_leaf).min().unwrap_or(0),
        end_leaf: children.clone().map(|k| k.end_leaf).max().unwrap_or(0),
        first_child,
        child_count,
        kind: if same { kind } else { ClusterKind::Mixed },
        fills_box: same && children.clone().all(|k| k.fills_box) && fills.is_filled(),
    }
}

/// Half angle of the cone about `axis` that holds the cones of all children, rad.
fn common_cone(children: impl Iterator<Item = ClusterNode>, axis: Vec3) -> f64 {
    children.fold(0.0f64, |m, k| {
        if k.kind == ClusterKind::Voxel {
            return 0.0;
        }
        let n = k.normal().normalized();
        let between = axis.cross(n).length().atan2(axis.dot(n));
        let own = if k.cone_sine > 1.0 { WIDE_CONE } else { (k.cone_sine as f64).asin() };
        m.max(between + own)
    })
}

/// The bounding box of zones that do not overlap, with their common moments.
struct NodeBox {
    kind: ClusterKind,
    lo: Vec3,
    hi: Vec3,
    /// Unit normal.
    normal: Vec3,
    /// Half angle of the cone of the normals, rad.
    cone: f64,
    measure: f64,
}

impl NodeBox {
    /// True where the zones fill the box; patches only in one axis-parallel plane.
    fn is_filled(&self) -> bool {
        let e = self.hi - self.lo;
        let box_measure = match self.kind {
            ClusterKind::Voxel => e.product(),
            ClusterKind::Patch => {
                let Some(x) = (0..3).find(|&x| self.normal[x].abs() > 1.0 - AXIS_TOLERANCE) else {
                    return false;
                };
                if self.cone > PLANE_CONE_TOLERANCE || e[x] > PLANE_THICKNESS_TOLERANCE * e.max_abs() {
                    return false;
                }
                e[(x + 1) % 3] * e[(x + 2) % 3]
            }
            _ => return false,
        };
        (self.measure / box_measure - 1.0).abs() < BOX_FILL_TOLERANCE
    }
}

/// The node of a zone, which is leaf `leaf` of the tree.
pub(crate) fn leaf_node(scene: &Scene, zones: &Zones, zone: usize, leaf: u32) -> ClusterNode {
    if zone < zones.voxel_offset() {
        let p = &zones.patches[zone];
        plate_node(scene, &p.plate, p.normal, p.area, (ClusterKind::Patch, leaf))
    } else if zone < zones.pane_offset() {
        let z = &zones.voxels[zone - zones.voxel_offset()];
        let grid = scene.voxel_grid().expect("voxel zones come from a voxel grid");
        let lo = grid.corner(grid.coordinates(z.cell));
        ClusterNode {
            centre: to_f32(z.centre),
            lo,
            hi: lo + grid.cell(),
            covariance: voxel_covariance(z, grid.cell()).map(|x| x as f32),
            measure: z.volume as f32,
            extinction: z.extinction.mean() as f32,
            kind: ClusterKind::Voxel,
            fills_box: z.samples.is_empty(),
            ..empty_leaf(leaf)
        }
    } else {
        let p = &zones.panes[zone - zones.pane_offset()];
        plate_node(scene, &p.plate, p.normal, p.area * p.thickness, (ClusterKind::Pane, leaf))
    }
}

fn empty_leaf(leaf: u32) -> ClusterNode {
    ClusterNode {
        centre: [0.0; 3],
        lo: Vec3::ZERO,
        hi: Vec3::ZERO,
        covariance: [0.0; 6],
        normal: [0.0; 3],
        cone_sine: 0.0,
        measure: 0.0,
        extinction: 0.0,
        first_leaf: leaf,
        end_leaf: leaf + 1,
        first_child: 0,
        child_count: 0,
        kind: ClusterKind::Patch,
        fills_box: false,
    }
}

/// The node of a patch or of a pane zone.
fn plate_node(
    scene: &Scene,
    plate: &Plate,
    normal: Vec3,
    measure: f64,
    (kind, leaf): (ClusterKind, u32),
) -> ClusterNode {
    let (lo, hi) = plate.bounds();
    ClusterNode {
        centre: to_f32(plate.centre()),
        lo,
        hi,
        covariance: plate_covariance(plate).map(|x| x as f32),
        normal: to_f32(normal),
        measure: measure as f32,
        extinction: extinction_at(scene, plate.centre()) as f32,
        fills_box: NodeBox { kind, lo, hi, normal, cone: 0.0, measure }.is_filled(),
        kind,
        ..empty_leaf(leaf)
    }
}

/// Extinction of the medium at a point, mean over the bands, 1/m.
fn extinction_at(scene: &Scene, p: Vec3) -> f64 {
    let Some(grid) = scene.voxel_grid() else {
        return 0.0;
    };
    grid.cell_at(p).map_or(0.0, |c| grid.extinction(grid.index(c)).mean())
}

/// Covariance of a uniform distribution over a plate: e₁e₁ᵀ/12 + e₂e₂ᵀ/12 of a parallelogram,
/// (e₁e₁ᵀ + e₂e₂ᵀ − (e₁e₂ᵀ + e₂e₁ᵀ)/2)/18 of a triangle.
fn plate_covariance(p: &Plate) -> [f64; 6] {
    let (a, b) = (p.e1, p.e2);
    let entry = |i: usize, j: usize| match p.kind {
        PlateKind::Parallelogram => (a[i] * a[j] + b[i] * b[j]) / 12.0,
        PlateKind::Triangle => (a[i] * a[j] + b[i] * b[j] - 0.5 * (a[i] * b[j] + b[i] * a[j])) / 18.0,
    };
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

/// Covariance of a voxel zone. A cut cell has that of a cell of its volume; its samples are not evaluated.
fn voxel_covariance(z: &VoxelZone, cell: Vec3) -> [f64; 6] {
    let whole = [cell.x * cell.x / 12.0, cell.y * cell.y / 12.0, cell.z * cell.z / 12.0, 0.0, 0.0, 0.0];
    if z.samples.is_empty() {
        return whole;
    }
    let share = (z.volume / cell.product()).min(1.0).powf(2.0 / 3.0);
    whole.map(|x| x * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn covariance_of_a_plate_follows_from_its_quarters() {
        for kind in [PlateKind::Triangle, PlateKind::Parallelogram] {
            let p = Plate { origin: Vec3::ONE, e1: vec3(2.0, 0.1, 0.0), e2: vec3(0.3, 1.0, 0.7), kind };
            let whole = plate_covariance(&p);
            let c = p.centre();
            let mut sum = [0.0; 6];
            for q in p.quarters() {
                let (d, own) = (q.centre() - c, plate_covariance(&q));
                let outer = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
                (0..6).for_each(|m| sum[m] += 0.25 * (outer[m] + own[m]));
            }
            (0..6).for_each(|m| assert!((sum[m] - whole[m]).abs() < 1e-13, "{kind:?} {m}"));
        }
    }
}
