//! What the refinement is driven by: powers, their variation and tolerances of all nodes, from a rough solution.

use super::refine::Demand;
use super::tree::{Kind, Tree};
use zonal_exchange::pair::strength;
use zonal_scene::{Bands, Zones};

/// α: how much a dark zone's own value counts in its tolerance.
const DARK: f64 = 0.8;
/// Uniform strength, relative to the mean of what arrives, that every node is taken to have at least.
const FLOOR: f64 = 0.03;

/// A light group as far as it is known: strengths c B and what arrives, H or G, of every zone.
pub struct Known<'a> {
    /// c B.
    pub strengths: &'a [Bands],
    /// H of patches, G of volumes.
    pub arriving: &'a [Bands],
}

/// Mean of what arrives at patches and at volumes, a band.
fn means(tree: &Tree, zones: &Zones, arriving: &[Bands]) -> [Bands; 2] {
    let mut sums = [[0.0; 3]; 2];
    let mut weights = [0.0; 2];
    for slot in 0..tree.leaves() {
        let n = &tree.nodes[tree.leaf(slot)];
        let zone = tree.zone[slot] as usize;
        let k = usize::from(zone >= zones.voxel_offset());
        if n.kind == Kind::Pane {
            continue;
        }
        weights[k] += n.weight as f64;
        (0..3).for_each(|b| sums[k][b] += n.weight as f64 * arriving[zone][b]);
    }
    [0, 1].map(|k| sums[k].map(|s| if weights[k] > 0.0 { s / weights[k] } else { 0.0 }))
}

/// Demands for ε from what is known of each light group.
pub fn demand(tree: &Tree, zones: &Zones, groups: &[Known], epsilon: f64) -> Demand {
    let nodes = tree.nodes.len();
    let mut power = vec![0.0f32; nodes];
    let mut varied = vec![0.0f32; nodes];
    let mut bright = vec![0.0f32; nodes];
    let mut volume: f64 = 0.0;
    for known in groups {
        let [patches, volumes] = means(tree, zones, known.arriving);
        for b in 0..3 {
            if b > 0 && same_band(known, b) {
                continue;
            }
            let surface = if patches[b] > 0.0 { patches[b] } else { 0.25 * volumes[b] };
            if surface <= 0.0 {
                continue;
            }
            let gas = if volumes[b] > 0.0 { volumes[b] } else { 4.0 * surface };
            volume = volume.max(surface / gas);
            column(tree, zones, known, b, [surface, gas], [&mut power, &mut varied, &mut bright]);
        }
    }
    let tolerance = (0..nodes)
        .map(|n| {
            let leaves = tree.nodes[n].leaves() as f64;
            let h = (bright[n] as f64).min(1.0);
            (epsilon * ((1.0 - DARK) + DARK * h) / leaves.sqrt()) as f32
        })
        .collect();
    Demand { power, varied, tolerance, volume: if volume > 0.0 { volume } else { 0.25 } }
}

/// True where this band's strengths are those of the band before: nothing new to ask for.
fn same_band(known: &Known, b: usize) -> bool {
    known.strengths.iter().all(|s| s[b] == s[b - 1])
}

fn column(
    tree: &Tree,
    zones: &Zones,
    known: &Known,
    b: usize,
    scale: [f64; 2],
    [power, varied, bright]: [&mut [f32]; 3],
) {
    // W, Σ W s, Σ W s², Σ W H/scale of the inner nodes, relative to the scale.
    let nodes = tree.nodes.len();
    let mut sums = vec![[0.0f64; 3]; nodes];
    for n in (0..nodes).rev() {
        let node = &tree.nodes[n];
        if node.is_leaf() {
            let zone = tree.zone[node.first as usize] as usize;
            let w = node.weight as f64;
            let s = (known.strengths[zone][b] + FLOOR * scale[0] * strength(zones, zone)[b]) / scale[0];
            let unit = if node.kind == Kind::Patch { scale[0] } else { scale[1] };
            let h = known.arriving[zone][b] / unit;
            sums[n] = [w * s, w * s * s, w * h];
        } else {
            sums[n] = tree.kids(n as u32).iter().fold([0.0; 3], |t, &k| {
                let x = sums[k as usize];
                [t[0] + x[0], t[1] + x[1], t[2] + x[2]]
            });
        }
        let w = node.weight as f64;
        let mean = sums[n][0] / w;
        let sigma = (sums[n][1] / w - mean * mean).max(0.0).sqrt();
        power[n] = power[n].max(sums[n][0] as f32);
        varied[n] = varied[n].max((w * sigma) as f32);
        bright[n] = bright[n].max((sums[n][2] / w) as f32);
    }
}
