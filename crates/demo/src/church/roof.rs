//! Roofs over the vaults and the walls between vaults and roofs, which seal the church.
//!
//! A zone has one radiosity. The flanks of a rib reach through the vault by a few centimetres: sunlight on their outer part would appear inside, so
//! that part is under a roof.

use super::arch::PointedArch;
use super::furniture::CAPITAL_HEIGHT;
use super::layout::Church;
use super::model::{ChurchMaterial, ChurchModel};
use super::plan::{AISLE_VAULT_RISE, BAY_LENGTH, NAVE_VAULT, NAVE_WALL_OFFSETS, OUTER_WALL_OFFSET, SIDES};
use super::wall::{BorderLine, WallFrame, WallSection};
use zonal_math::{Vec3, vec3};

/// Roofs over the crowns of their vaults, m.
const ROOF_CLEARANCE: f64 = 0.05;

/// Roofs and gables.
pub(super) fn build(m: &mut ChurchModel, church: &Church) {
    let (l, high, low) = (
        church.end(),
        NAVE_VAULT.0 + NAVE_VAULT.1 + ROOF_CLEARANCE,
        CAPITAL_HEIGHT + AISLE_VAULT_RISE + ROOF_CLEARANCE,
    );
    let mut nave = church.choir(NAVE_WALL_OFFSETS.0, high);
    nave.extend([vec3(-NAVE_WALL_OFFSETS.0, 0.0, high), vec3(NAVE_WALL_OFFSETS.0, 0.0, high)]);
    m.polygon(ChurchMaterial::Oak, &nave, vec3(0.0, 1.0, 0.0));
    let corners = church.choir(NAVE_WALL_OFFSETS.0, 0.0);
    for pair in corners.windows(2) {
        let at = |p: Vec3, z: f64| vec3(p.x, p.y, z);
        let side =
            [at(pair[0], NAVE_VAULT.0), at(pair[1], NAVE_VAULT.0), at(pair[1], high), at(pair[0], high)];
        m.polygon(ChurchMaterial::Ashlar, &side, vec3(0.0, l, NAVE_VAULT.0));
    }
    let west = WallFrame::new(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    gable(
        m,
        west,
        PointedArch::new(NAVE_WALL_OFFSETS.0, NAVE_VAULT.1, church.plan.pieces),
        NAVE_VAULT.0,
        high,
    );
    for s in SIDES {
        aisle_roof(m, church, s, low);
        for bay in 0..church.plan.bays {
            walls_above_vaults(m, church, s, bay, high, low);
        }
    }
}

/// The roof of the aisle on side `s` at height `low`, its gables, and the ends of the wall between nave and aisle.
fn aisle_roof(m: &mut ChurchModel, church: &Church, s: f64, low: f64) {
    let l = church.end();
    let x = [s * NAVE_WALL_OFFSETS.0, s * OUTER_WALL_OFFSET];
    let roof = [vec3(x[0], 0.0, low), vec3(x[1], 0.0, low), vec3(x[1], l, low), vec3(x[0], l, low)];
    m.polygon(ChurchMaterial::Oak, &roof, vec3(x[0], 0.0, 0.0));
    for (y, inward) in [(0.0, 1.0), (l, -1.0)] {
        let (frame, arch) = church.end_of_aisle(s, y, vec3(0.0, inward, 0.0));
        gable(m, frame, arch, CAPITAL_HEIGHT, low);
        // The end of the wall between nave and aisle.
        let z = [CAPITAL_HEIGHT, low];
        let (a, b) = (s * NAVE_WALL_OFFSETS.0, s * NAVE_WALL_OFFSETS.1);
        let end = [vec3(a, y, z[0]), vec3(b, y, z[0]), vec3(b, y, z[1]), vec3(a, y, z[1])];
        m.polygon(ChurchMaterial::Ashlar, &end, vec3(a, 0.5 * l, 0.0));
    }
}

/// The walls of nave and aisle on the side `s` between the vaults of a bay and their roofs at heights `high` and `low`.
fn walls_above_vaults(m: &mut ChurchModel, church: &Church, s: f64, bay: usize, high: f64, low: f64) {
    let nave = church.vault(bay, -NAVE_WALL_OFFSETS.0, NAVE_WALL_OFFSETS.0, NAVE_VAULT.0, NAVE_VAULT.1);
    let aisle = church.vault(bay, NAVE_WALL_OFFSETS.1, OUTER_WALL_OFFSET, CAPITAL_HEIGHT, AISLE_VAULT_RISE);
    for (x, vault, top) in [(NAVE_WALL_OFFSETS.0, nave, high), (OUTER_WALL_OFFSET, aisle, low)] {
        let frame = church.side(s, x, bay);
        let (lower, upper) = (BorderLine(vault.edge()), BorderLine::level(top));
        let ends = (-0.5 * BAY_LENGTH, 0.5 * BAY_LENGTH);
        WallSection { frame, ends, lower, upper, opening: None }.build(m);
    }
}

/// The wall above an arch that springs at `z`, up to `top`.
fn gable(m: &mut ChurchModel, frame: WallFrame, arch: PointedArch, z: f64, top: f64) {
    let (lower, upper) = (BorderLine::arch(&arch, z), BorderLine::level(top));
    WallSection { frame, ends: (-arch.half, arch.half), lower, upper, opening: None }.build(m);
}
