//! One path of light, backwards from a vertex: I = ∫ L f dω with f the density of the vertex's own scattering.
//!
//! At each vertex the path asks the suns and one point of an emitter, then goes on in a direction of density f. Emission that is
//! met on the way counts too; both ways of finding an emitter share it by the balance heuristic (Veach 1997): with p_e the
//! density of the emitter's point,
//!
//! ```text
//! asked:  β τ L f/(p_e + f)        met:  β L f/(p_e + f)
//! ```
//!
//! After a few bounces a path lives on with the probability of its last albedo, and what lives is weighted up, so that no mean
//! changes. Light that comes unscattered from a sun, a sky or a surface that the scene lists as a light is direct.

use super::lamps::Lamps;
use super::space::{Fate, Space, Vertex, scattered};
use crate::Dice;
use zonal_math::Vec3;
use zonal_scene::{Bands, Sides, bands};

/// Bounces before a path may end by chance.
const CERTAIN: usize = 3;
/// The largest chance to live on: in a white closed scene paths end nevertheless.
const MOST: f64 = 0.995;

/// The numbers of a path: well spread ones for its first steps, then random ones.
pub struct Draws {
    /// Numbers in [0, 1), taken from the end.
    pub spread: Vec<f64>,
    /// The rest.
    pub dice: Dice,
}

impl Draws {
    /// The next number of [0, 1).
    pub fn draw(&mut self) -> f64 {
        self.spread.pop().unwrap_or_else(|| self.dice.roll())
    }
    /// The next numbers.
    pub fn some<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.draw())
    }
}

/// What a path found, as a radiance, W/(m² sr).
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// All of it.
    pub total: Bands,
    /// Direct light alone.
    pub direct: Bands,
}

impl Found {
    fn add(&mut self, x: Bands, direct: bool) {
        self.total = bands(|b| self.total[b] + x[b]);
        if direct {
            self.direct = bands(|b| self.direct[b] + x[b]);
        }
    }
}

/// Where paths run.
pub struct Paths<'a> {
    /// The scene with its trees.
    pub space: Space<'a>,
    /// Its lights.
    pub lamps: Lamps<'a>,
    /// The most bounces between receiver and emission.
    pub max_bounces: usize,
}

/// A path under way.
struct State {
    vertex: Vertex,
    beta: Bands,
    bounces: usize,
    found: Found,
}

impl Paths<'_> {
    /// ∫ L f dω at a vertex by one path.
    pub fn received(&self, vertex: Vertex, draws: &mut Draws) -> Found {
        let mut s = State { vertex, beta: [1.0; 3], bounces: 0, found: Found::default() };
        self.ask(&mut s, draws);
        let d = scattered(&s.vertex, draws.some());
        self.run(s, d, false, draws)
    }

    /// Radiance that arrives at `o` against the unit direction `d`, by one path. Suns are not seen as discs.
    pub fn radiance(&self, o: Vec3, d: Vec3, draws: &mut Draws) -> Found {
        let vertex = Vertex::Free { at: o };
        let s = State { vertex, beta: [1.0; 3], bounces: 0, found: Found::default() };
        self.run(s, d, true, draws)
    }

    /// Follows the path from its vertex along `d`; `looking`: emission that is met first is not asked for elsewhere.
    fn run(&self, mut s: State, mut d: Vec3, mut looking: bool, draws: &mut Draws) -> Found {
        while self.step(&mut s, d, looking, draws) {
            looking = false;
            self.ask(&mut s, draws);
            d = scattered(&s.vertex, draws.some());
        }
        s.found
    }

    /// Flies to the next vertex; false when the path ends.
    fn step(&self, s: &mut State, d: Vec3, looking: bool, draws: &mut Draws) -> bool {
        // The distance from the spread numbers, the band by chance.
        let u = [draws.dice.roll(), draws.draw()];
        let flight = self.space.fly(&s.vertex, d, s.beta, u);
        s.found.add(bands(|b| s.beta[b] * flight.sent[b]), false);
        s.beta = bands(|b| s.beta[b] * flight.weight[b]);
        let first = s.bounces == 0;
        let albedo = match flight.fate {
            Fate::Escaped => {
                let around = self.space.scene.surroundings().radiance;
                s.found.add(bands(|b| s.beta[b] * around[b]), false);
                s.found.add(bands(|b| s.beta[b] * self.lamps.sky[b]), first);
                return false;
            }
            Fate::Collision(vertex, albedo) => {
                s.vertex = vertex;
                albedo
            }
            Fate::Facet(met) => {
                let facet = &self.space.scene.facets()[met.id as usize];
                let normal = facet.plate.normal();
                let (radiance, direct) = self.lamps.radiance(met.id, met.uv, met.front);
                if radiance != [0.0; 3] {
                    let f = s.vertex.density(d);
                    let asked = self.lamps.density(met.id, met.t, normal.dot(d));
                    let share = if looking { 1.0 } else { f / (f + asked) };
                    s.found.add(bands(|b| s.beta[b] * radiance[b] * share), direct && first);
                }
                if !met.front && self.space.scene.surfaces()[facet.surface].sides == Sides::Front {
                    return false;
                }
                let at = s.vertex.at() + d * met.t;
                let normal = if met.front { normal } else { -normal };
                s.vertex = Vertex::Surface { at, normal, facet: Some(met.id) };
                self.space.scene.reflectance_at(met.id as usize, met.uv[0], met.uv[1])
            }
        };
        self.scatter(s, albedo, draws)
    }

    fn scatter(&self, s: &mut State, albedo: Bands, draws: &mut Draws) -> bool {
        let before = s.beta.iter().fold(0.0f64, |m, x| m.max(*x));
        s.beta = bands(|b| s.beta[b] * albedo[b]);
        s.bounces += 1;
        let after = s.beta.iter().fold(0.0f64, |m, x| m.max(*x));
        if after <= 0.0 || s.bounces > self.max_bounces {
            return false;
        }
        if s.bounces > CERTAIN {
            let chance = (after / before).min(MOST);
            if draws.dice.roll() >= chance {
                return false;
            }
            s.beta = s.beta.map(|x| x / chance);
        }
        true
    }

    /// Asks suns and emitters what they send to the vertex.
    fn ask(&self, s: &mut State, draws: &mut Draws) {
        let direct = s.bounces == 0;
        let u: [f64; 3] = draws.some();
        for k in 0..self.lamps.suns() {
            let u = if k == 0 { [u[0], u[1]] } else { [draws.dice.roll(), draws.dice.roll()] };
            let (towards, flux) = self.lamps.sun(k, u);
            let f = s.vertex.density(towards);
            if f > 0.0
                && let Some(tau) = self.space.transmittance(&s.vertex, towards, f64::INFINITY, None)
            {
                s.found.add(bands(|b| s.beta[b] * tau[b] * flux[b] * f), direct);
            }
        }
        let u =
            if self.lamps.suns() > 0 { [draws.dice.roll(), draws.dice.roll(), draws.dice.roll()] } else { u };
        let Some(spot) = self.lamps.spot(u) else { return };
        let way = spot.at - s.vertex.at();
        let r = way.length();
        let towards = way / r;
        let cos = -towards.dot(spot.normal);
        let (radiance, listed) = self.lamps.radiance(spot.facet, spot.uv, cos > 0.0);
        let f = s.vertex.density(towards);
        if !(r > 0.0 && cos != 0.0 && f > 0.0) || radiance == [0.0; 3] {
            return;
        }
        let share = f / (f + self.lamps.density(spot.facet, r, cos));
        if let Some(tau) = self.space.transmittance(&s.vertex, towards, r, Some(spot.facet)) {
            s.found.add(bands(|b| s.beta[b] * tau[b] * radiance[b] * share), direct && listed);
        }
    }
}
