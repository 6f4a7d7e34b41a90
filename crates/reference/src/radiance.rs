//! H of a plate and G in a box by random walks of light, backwards: no zones, no factors, no equations.
//!
//! A walk ends on what it meets with the probability of absorption and collects on its way: E on a wall, (1 − Ω)E + q/(4κ) where it
//! collides in the medium, (1 − Ω)E in a pane, π L of the surroundings. H is the mean over walks that start with cosine density, G four
//! times the mean over uniform directions. Direct lights are not looked at.

use crate::{Dice, Estimate, Tally, World};
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Plate, Sides};

/// H of the front of a plate in a band, W/m².
pub fn irradiance(w: &World, plate: &Plate, band: usize, n: usize, seed: u64) -> Estimate {
    let (mut dice, mut tally) = (Dice::new(seed), Tally::default());
    for _ in 0..n {
        let (o, d) = (dice.on_plate(plate), dice.cosine(plate.normal()));
        tally.add(walk(w, o, d, band, &mut dice));
    }
    tally.estimate(1.0)
}

/// G in a box in a band, W/m².
pub fn fluence(w: &World, lo: Vec3, hi: Vec3, band: usize, n: usize, seed: u64) -> Estimate {
    let (mut dice, mut tally) = (Dice::new(seed), Tally::default());
    for _ in 0..n {
        let (o, d) = (dice.in_box(lo, hi), dice.direction());
        tally.add(walk(w, o, d, band, &mut dice));
    }
    tally.estimate(4.0)
}

/// What the light along one walk adds up to, as a radiosity.
fn walk(w: &World, mut o: Vec3, mut d: Vec3, band: usize, dice: &mut Dice) -> f64 {
    let mut sum = 0.0;
    loop {
        let strike = w.first(o, d);
        let limit = strike.map_or(w.far, |s| s.t);
        // An optical distance, spent leg by leg.
        let mut rest = -(1.0 - dice.roll()).ln();
        let mut collision = None;
        for leg in w.legs(o, d, limit) {
            if let Some((pane, depth)) = leg.pane {
                if rest < depth[band] {
                    collision = Some((leg.from, None, Some(pane)));
                    break;
                }
                rest -= depth[band];
            }
            let kappa = w.kappa(&leg)[band];
            if rest < kappa * (leg.to - leg.from) {
                collision = Some((leg.from + rest / kappa, leg.cell, None));
                break;
            }
            rest -= kappa * (leg.to - leg.from);
        }
        let (albedo, emission, at) = match (collision, strike) {
            (Some((t, Some(cell), _)), _) => {
                let map = w.scene.voxmap().expect("a cell has a voxmap");
                let source = map.source(cell)[band] / (4.0 * map.extinction(cell)[band]);
                let albedo = map.albedo(cell)[band];
                (albedo, (1.0 - albedo) * map.emission(cell)[band] + source, Some(t))
            }
            (Some((t, _, pane)), _) => {
                let p = &w.scene.panes()[pane.expect("a collision is in a cell or a pane")];
                let n = p.plates[0].normal();
                let n = if n.dot(d) > 0.0 { n } else { -n };
                match within(p, band, n.dot(d), dice, &mut sum) {
                    None => return sum,
                    // Out on the far side (+1) or on the near one (−1).
                    Some(out) => {
                        o += d * t;
                        d = out.0 * n + out.1 * d_across(n, dice);
                        continue;
                    }
                }
            }
            (None, None) => return sum + PI * w.scene.surroundings().radiance[band],
            (None, Some(s)) => {
                let f = &w.scene.facets()[s.facet];
                if !s.front && w.scene.surfaces()[f.surface].sides == Sides::Front {
                    return sum;
                }
                let [u, v] = s.uv;
                (w.scene.reflectance_at(s.facet, u, v)[band], w.scene.emission_at(s.facet, u, v)[band], None)
            }
        };
        sum += emission;
        if dice.roll() >= albedo {
            return sum;
        }
        match at {
            Some(t) => {
                o += d * t;
                d = dice.direction();
            }
            None => {
                let s = strike.expect("a wall was met");
                let n = w.scene.facets()[s.facet].plate.normal();
                o += d * s.t;
                d = dice.cosine(if s.front { n } else { -n });
            }
        }
    }
}

/// A unit vector at random square to `n`.
fn d_across(n: Vec3, dice: &mut Dice) -> Vec3 {
    let a =
        if n.x.abs() < 0.6 { Vec3::from_array([1.0, 0.0, 0.0]) } else { Vec3::from_array([0.0, 1.0, 0.0]) };
    let t = a.cross(n).normalized();
    let turn = std::f64::consts::TAU * dice.roll();
    t * turn.cos() + n.cross(t) * turn.sin()
}

/// Collisions within a pane, entered at cosine `c`, one of which is certain: the cosine with the forward normal at which the walk
/// leaves, and the sine; nothing when it ends inside. Collects emission.
fn within(p: &zonal_scene::Pane, band: usize, c: f64, dice: &mut Dice, sum: &mut f64) -> Option<(f64, f64)> {
    let kappa = p.extinction[band];
    let all = kappa * p.thickness / c;
    // The first collision, given that there is one.
    let first = -(1.0 - dice.roll() * (1.0 - (-all).exp())).ln();
    let mut depth = first / kappa * c;
    loop {
        *sum += (1.0 - p.albedo[band]) * p.emission[band];
        if dice.roll() >= p.albedo[band] {
            return None;
        }
        let cos = 2.0 * dice.roll() - 1.0;
        depth -= (1.0 - dice.roll()).ln() / kappa * cos;
        if depth < 0.0 || depth > p.thickness {
            return Some((cos, (1.0 - cos * cos).sqrt()));
        }
    }
}
