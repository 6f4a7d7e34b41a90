//! What keeps the light out: roofs over the vaults, the walls between vaults and roofs, buttresses behind the shafts.
//!
//! A zone has one radiosity. Where a capital or a rib reaches through a wall or a vault by a hand's breadth, sun on what is outside would shine
//! inside: so it is dark there, as under any roof.

use super::arch::Arch;
use super::furniture::CAPITAL;
use super::model::{Model, Stuff};
use super::wall::{Frame, Line, Wall};
use super::{BAY, Church, HIGH, LOW, NAVE, OUTER, SIDES};
use zonal_math::{Vec3, vec3};

/// Roofs over the crowns of their vaults, m.
const OVER: f64 = 0.05;
/// A buttress: half its breadth, and how far it stands out, m.
const BUTTRESS: (f64, f64) = (0.4, 0.5);
/// What stands behind a wall keeps so far off it, m.
const OFF: f64 = 0.001;
/// From below the springing to where ribs have left the corner, m from the springing.
const FOOT: (f64, f64) = (-0.6, 1.6);

/// Roofs, gables and buttresses.
pub fn build(m: &mut Model, church: &Church) {
    let (l, high, low) = (church.end(), HIGH.0 + HIGH.1 + OVER, CAPITAL + LOW + OVER);
    let mut nave = church.choir(NAVE.0, high);
    nave.extend([vec3(-NAVE.0, 0.0, high), vec3(NAVE.0, 0.0, high)]);
    m.polygon(Stuff::Oak, &nave, vec3(0.0, 1.0, 0.0));
    let corners = church.choir(NAVE.0, 0.0);
    for pair in corners.windows(2) {
        let at = |p: Vec3, z: f64| vec3(p.x, p.y, z);
        let side = [at(pair[0], HIGH.0), at(pair[1], HIGH.0), at(pair[1], high), at(pair[0], high)];
        m.polygon(Stuff::Ashlar, &side, vec3(0.0, l, HIGH.0));
    }
    let west = Frame::new(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    gable(m, west, Arch::new(NAVE.0, HIGH.1, church.plan.pieces), HIGH.0, high);
    for s in SIDES {
        let x = [s * NAVE.0, s * OUTER];
        let roof = [vec3(x[0], 0.0, low), vec3(x[1], 0.0, low), vec3(x[1], l, low), vec3(x[0], l, low)];
        m.polygon(Stuff::Oak, &roof, vec3(x[0], 0.0, 0.0));
        for (y, inward) in [(0.0, 1.0), (l, -1.0)] {
            let (frame, arch) = church.end_of_aisle(s, y, vec3(0.0, inward, 0.0));
            gable(m, frame, arch, CAPITAL, low);
            // The end of the wall between nave and aisle.
            let z = [CAPITAL, low];
            let (a, b) = (s * NAVE.0, s * NAVE.1);
            let end = [vec3(a, y, z[0]), vec3(b, y, z[0]), vec3(b, y, z[1]), vec3(a, y, z[1])];
            m.polygon(Stuff::Ashlar, &end, vec3(a, 0.5 * l, 0.0));
        }
        for (y, out) in [(0.0, -1.0), (l, 1.0)] {
            before(m, vec3(s * NAVE.1, y, CAPITAL), out);
            corner(m, vec3(s * OUTER, y, CAPITAL), out);
        }
        corner(m, vec3(s * NAVE.0, 0.0, HIGH.0), -1.0);
        for bay in 0..church.plan.bays {
            let vaults = [
                (NAVE.0, church.vault(bay, (-NAVE.0, NAVE.0), HIGH.0, HIGH.1), high),
                (OUTER, church.vault(bay, (NAVE.1, OUTER), CAPITAL, LOW), low),
            ];
            for (x, vault, top) in vaults {
                let frame = church.side(s, x, bay);
                let (lower, upper) = (Line(vault.edge()), Line::level(top));
                Wall { frame, ends: (-0.5 * BAY, 0.5 * BAY), lower, upper, opening: None }.build(m);
            }
        }
        for bay in 1..church.plan.bays {
            let y = church.border(bay);
            for (x, z0, z1) in [(OUTER, 0.0, CAPITAL + FOOT.1), (NAVE.0, CAPITAL + 0.1, HIGH.0 + FOOT.1)] {
                let (a, b) = (s * (x + OFF), s * (x + BUTTRESS.1));
                let lo = vec3(a.min(b), y - BUTTRESS.0, z0);
                m.block(Stuff::Ashlar, lo, vec3(a.max(b), y + BUTTRESS.0, z1));
            }
        }
    }
    let axis = vec3(0.0, l, 0.0);
    for (k, &corner) in corners.iter().enumerate() {
        let out = (corner - axis).normalized();
        for to in [k.checked_sub(1), Some(k + 1)].into_iter().flatten().filter_map(|j| corners.get(j)) {
            let along = (*to - corner).normalized();
            let n = vec3(along.y, -along.x, 0.0);
            let n = if n.dot(out) > 0.0 { n } else { -n };
            let foot = corner + n * OFF;
            let base = [
                foot,
                foot + along * BUTTRESS.0,
                foot + along * BUTTRESS.0 + n * BUTTRESS.1,
                foot + out * BUTTRESS.1,
            ];
            m.prism(Stuff::Ashlar, &base, vec3(0.0, 0.0, HIGH.0 + FOOT.1));
        }
    }
}

/// A buttress before an end wall, beyond which `out` is, where ribs spring at `foot`.
fn before(m: &mut Model, foot: Vec3, out: f64) {
    let (a, b) = (foot.y + out * OFF, foot.y + out * BUTTRESS.1);
    let lo = vec3(foot.x - BUTTRESS.1, a.min(b), foot.z + FOOT.0);
    m.block(Stuff::Ashlar, lo, vec3(foot.x + BUTTRESS.1, a.max(b), foot.z + FOOT.1));
}

/// Buttresses on both sides of an outer corner.
fn corner(m: &mut Model, foot: Vec3, out: f64) {
    before(m, foot, out);
    let (a, b) = (foot.x + foot.x.signum() * OFF, foot.x + foot.x.signum() * BUTTRESS.1);
    let (c, d) = (foot.y, foot.y - out * BUTTRESS.0);
    let lo = vec3(a.min(b), c.min(d), foot.z + FOOT.0);
    m.block(Stuff::Ashlar, lo, vec3(a.max(b), c.max(d), foot.z + FOOT.1));
}

/// The wall above an arch that springs at `z`, up to `top`.
fn gable(m: &mut Model, frame: Frame, arch: Arch, z: f64, top: f64) {
    let (lower, upper) = (Line::arch(&arch, z), Line::level(top));
    Wall { frame, ends: (-arch.half, arch.half), lower, upper, opening: None }.build(m);
}
