//! What keeps the light out: roofs over the vaults, and the walls between vaults and roofs.
//!
//! A zone has one radiosity. The flanks of a rib reach through the vault by a hand's breadth: sun on what is outside would shine inside, so it is
//! dark there, as under any roof.

use super::arch::Arch;
use super::furniture::CAPITAL;
use super::model::{Model, Stuff};
use super::wall::{Frame, Line, Wall};
use super::{BAY, Church, HIGH, LOW, NAVE, OUTER, SIDES};
use zonal_math::{Vec3, vec3};

/// Roofs over the crowns of their vaults, m.
const OVER: f64 = 0.05;
/// Roofs and gables.
pub(super) fn build(m: &mut Model, church: &Church) {
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
    }
}

/// The wall above an arch that springs at `z`, up to `top`.
fn gable(m: &mut Model, frame: Frame, arch: Arch, z: f64, top: f64) {
    let (lower, upper) = (Line::arch(&arch, z), Line::level(top));
    Wall { frame, ends: (-arch.half, arch.half), lower, upper, opening: None }.build(m);
}
