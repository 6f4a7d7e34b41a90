//! The scene hash: BLAKE3 over the numbers of a scene in a fixed order, as 64 hexadecimal digits.
//!
//! Every number enters as a little-endian word of 64 bits, f64 (−0 as 0) or u64, and every list is preceded by its length. Names, notes
//! and cameras are excluded, since they do not change a solution. The hash identifies the scene of a solution or checkpoint; it is
//! compared with hashes of the same program only.

use zonal_math::Vec3;
use zonal_scene::{
    BandFractions, Bands, Light, LinkLaw, NodeCondition, Plate, PlateKind, Scene, Sides, Thermal,
    ThermalCondition, ThermalNetwork,
};

/// Bytes that are gathered before they are hashed.
const BUFFER_BYTES: usize = 1 << 14;

/// A hash over words.
struct WordHasher {
    hasher: blake3::Hasher,
    buffer: Vec<u8>,
}

impl WordHasher {
    fn new() -> WordHasher {
        WordHasher { hasher: blake3::Hasher::new(), buffer: Vec::with_capacity(BUFFER_BYTES) }
    }
    fn word(&mut self, word: u64) {
        self.buffer.extend_from_slice(&word.to_le_bytes());
        if self.buffer.len() >= BUFFER_BYTES {
            self.hasher.update(&self.buffer);
            self.buffer.clear();
        }
    }
    /// The digest as hexadecimal digits.
    fn finish(mut self) -> String {
        self.hasher.update(&self.buffer);
        self.hasher.finalize().to_hex().to_string()
    }
    fn int(&mut self, n: usize) {
        self.word(n as u64);
    }
    fn real(&mut self, x: f64) {
        self.word((x + 0.0).to_bits());
    }
    fn reals(&mut self, xs: &[f64]) {
        xs.iter().for_each(|&x| self.real(x));
    }
    fn bands(&mut self, x: Bands) {
        self.reals(x.as_slice());
    }
    fn vec(&mut self, v: Vec3) {
        self.reals(&v.array());
    }
    fn option(&mut self, x: Option<usize>) {
        self.int(x.map_or(0, |n| n + 1));
    }
    fn length(&mut self, x: Option<f64>) {
        self.real(x.unwrap_or(-1.0));
    }
    fn plate(&mut self, p: &Plate) {
        self.int((p.kind == PlateKind::Parallelogram) as usize);
        [p.origin, p.e1, p.e2].into_iter().for_each(|v| self.vec(v));
    }
}

/// The hash of all that a solution depends on: 64 hexadecimal digits.
pub fn scene_hash(scene: &Scene) -> String {
    let mut h = WordHasher::new();
    scene.blocks().for_each(|block| hash_block(&mut h, &block));
    hash_bands(&mut h, scene);
    h.finish()
}

/// The hash of numbers: 64 hexadecimal digits.
pub(super) fn numbers_hash(numbers: impl Iterator<Item = f64>) -> String {
    let mut h = WordHasher::new();
    numbers.for_each(|x| h.reals(&[x]));
    h.finish()
}

/// Hashes the number of bands, if it is not three.
fn hash_bands(h: &mut WordHasher, scene: &Scene) {
    if !scene.bands().is_rgb() {
        h.int(scene.bands().count());
    }
    if scene.bands().has_solar_band() {
        h.int(1);
    }
}

/// A number for the treatment of closure.
fn closure_number(scene: &Scene) -> usize {
    scene.restores_closure() as usize + 2 * scene.restores_rows() as usize
}

/// Hashes one block of the bands.
fn hash_block(h: &mut WordHasher, scene: &Scene) {
    hash_surfaces(h, scene);
    hash_media(h, scene);
    hash_lights(h, scene);
    hash_thermal(h, scene);
    let o = scene.options();
    h.reals(&[o.tolerance, o.residual]);
    h.length(o.patch_size);
    h.int(o.patch_rule as usize);
    h.int(closure_number(scene));
    h.int(o.max_iterations);
    h.option(o.scattering_orders);
    h.int(o.engine as usize);
    h.int(o.light_grouping as usize);
    h.int(o.zone_basis as usize);
    h.option(o.discretization_error.map(usize::from));
}

/// The hash of all that the exchange factors and the direct light of a scene depend on: without reflectances, albedos, the emission of
/// zones that are no direct lights, and the settings of the iteration. 64 hexadecimal digits.
pub(crate) fn factors_hash(scene: &Scene) -> String {
    let mut h = WordHasher::new();
    scene.blocks().for_each(|block| hash_factors(&mut h, &block));
    hash_bands(&mut h, scene);
    h.finish()
}

/// Hashes what the exchange factors and the direct light of one block of the bands depend on.
fn hash_factors(h: &mut WordHasher, scene: &Scene) {
    let shining = scene.surroundings().has_radiance();
    let mut parts = scene.clone().into_parts();
    for (s, surface) in parts.surfaces.iter_mut().enumerate() {
        surface.reflectance = Bands::ZERO;
        surface.transmission.iter_mut().for_each(|t| t.transmittance = Bands::ZERO);
        if !scene.is_direct_emitter(s) {
            surface.emission = Bands::ZERO;
        }
    }
    parts.faces = Default::default();
    parts.panes.iter_mut().for_each(|p| (p.albedo, p.emission) = (Bands::ZERO, Bands::ZERO));
    if let Some(v) = &mut parts.voxel_grid {
        v.set_albedo(Bands::ZERO);
        v.scale_sources(Bands::ZERO);
        v.clear_heat();
    }
    parts.thermal = None;
    parts.surroundings.radiance = Bands::ZERO;
    // These changes keep a valid scene valid.
    let bare = Scene::new(parts).unwrap_or_else(|_| scene.clone());
    hash_surfaces(h, &bare);
    hash_media(h, &bare);
    hash_lights(h, &bare);
    let o = scene.options();
    h.real(o.tolerance);
    h.length(o.patch_size);
    [
        shining as usize,
        o.patch_rule as usize,
        closure_number(scene),
        o.engine as usize,
        o.zone_basis as usize,
    ]
    .into_iter()
    .for_each(|n| h.int(n));
}

/// Hashes nodes, links and convection.
fn hash_network(h: &mut WordHasher, network: &ThermalNetwork) {
    for node in &network.nodes {
        let (kind, x) = match node.condition {
            NodeCondition::Temperature(t) => (0, t),
            NodeCondition::Power(p) => (1, p),
        };
        h.int(kind);
        h.real(x);
    }
    for link in &network.links {
        let (kind, x) = match link.law {
            LinkLaw::Conductance(c) => (0, c),
            LinkLaw::ConductancePerArea(c) => (1, c),
            LinkLaw::EffectiveEmissivity(e) => (2, e),
        };
        link.nodes.iter().chain([&kind]).for_each(|n| h.int(*n));
        h.real(x);
    }
    network.surface_nodes.iter().for_each(|n| h.option(*n));
    for c in network.convection.iter().map(|c| c.map_or([-1.0, 0.0], |c| [c.coefficient, c.ambient])) {
        h.reals(&c);
    }
}

/// Hashes the conditions of thermal mode, if the scene has them.
fn hash_thermal(h: &mut WordHasher, scene: &Scene) {
    let Some(t) = scene.thermal() else { return };
    let known = |h: &mut WordHasher, k: ThermalCondition| {
        let (kind, x) = match k {
            ThermalCondition::Temperature(t) => (0, t),
            ThermalCondition::Flux(q) => (1, q),
            ThermalCondition::Power(p) => (2, p),
        };
        h.int(kind);
        h.real(x);
    };
    for fractions in t.all_fractions() {
        let (coefficients, range, allow_partial) = match fractions {
            BandFractions::Grey => continue,
            BandFractions::BlackBody { limits } => {
                limits.iter().for_each(|l| h.reals(l));
                continue;
            }
            BandFractions::GreyGases { coefficients, range, allow_partial, .. } => {
                (coefficients, range, allow_partial)
            }
        };
        h.reals(range);
        h.int(*allow_partial as usize);
        for c in coefficients {
            h.int(c.len());
            h.reals(c);
        }
    }
    if let Some(own) = &t.cell_fractions {
        own.kind_of_cell.iter().for_each(|k| h.int(*k as usize));
    }
    t.surfaces.iter().chain(&t.panes).for_each(|k| known(h, *k));
    t.network.iter().for_each(|n| hash_network(h, n));
    hash_emissivities(h, t);
    for (facet, v) in scene.faces().values.iter().enumerate() {
        if let Some(k) = v.condition {
            h.int(facet);
            // The power of a face is shared by its facets.
            h.option(scene.faces().face_of(facet));
            known(h, k);
        }
    }
    h.length(t.surroundings);
    if let Some(map) = scene.voxel_grid() {
        (0..map.len()).filter_map(|i| map.heat(i)).for_each(|k| known(h, k));
    }
}

/// Hashes emissivities by temperature and side.
fn hash_emissivities(h: &mut WordHasher, t: &Thermal) {
    for (surface, e) in t.emissivities.iter().enumerate().filter(|(_, e)| **e != Default::default()) {
        h.int(surface);
        let tables = [e.table.as_ref(), e.back.as_ref().and_then(|b| b.table.as_ref())];
        e.back.iter().for_each(|b| h.bands(b.reflectance));
        for points in tables.map(|t| t.map_or(&[][..], |t| t.points())) {
            h.int(points.len());
            points.iter().for_each(|p| h.reals(p));
        }
    }
}

/// Hashes surfaces, facets and textures.
fn hash_surfaces(h: &mut WordHasher, scene: &Scene) {
    h.int(scene.surfaces().len());
    for s in scene.surfaces() {
        h.bands(s.reflectance);
        h.bands(s.emission);
        h.option(s.reflectance_texture);
        h.option(s.emission_texture);
        h.int((s.sides == Sides::Both) as usize);
        h.length(s.patch_size);
        h.int(s.solid as usize);
        if let Some(t) = s.transmission {
            h.bands(t.transmittance);
            h.option(t.texture);
        }
    }
    h.int(scene.facets().len());
    for f in scene.facets() {
        h.int(f.surface);
        h.plate(&f.plate);
        f.uv.iter().for_each(|t| h.reals(t));
    }
    for (facet, v) in scene.faces().values.iter().enumerate() {
        for (kind, x) in [v.reflectance, v.emission].into_iter().enumerate() {
            if let Some(x) = x {
                h.int(facet);
                h.int(kind);
                h.bands(x);
            }
        }
    }
    h.int(scene.textures().len());
    for t in scene.textures() {
        h.int(t.width);
        t.pixels.iter().flatten().for_each(|&x| h.real(x as f64));
    }
}

/// Hashes panes and the medium.
fn hash_media(h: &mut WordHasher, scene: &Scene) {
    h.int(scene.panes().len());
    for p in scene.panes() {
        h.int(p.plates.len());
        p.plates.iter().for_each(|q| h.plate(q));
        h.real(p.thickness);
        [p.extinction, p.albedo, p.emission].into_iter().for_each(|x| h.bands(x));
    }
    if scene.is_periodic() {
        scene.periodic().into_iter().for_each(|p| h.int(p as usize));
    }
    if scene.has_mirrors() {
        scene.mirrors().into_iter().flatten().for_each(|m| h.int(m as usize));
    }
    if let Some((min, max)) = scene.boundary_box().filter(|_| scene.voxel_grid().is_none()) {
        [min, max].into_iter().for_each(|p| h.vec(p));
    }
    h.int(scene.voxel_grid().map_or(0, |v| v.len()));
    if let Some(v) = scene.voxel_grid() {
        h.vec(v.min());
        h.vec(v.cell());
        v.dims().into_iter().for_each(|d| h.int(d));
        for i in 0..v.len() {
            [v.extinction(i), v.albedo(i), v.emission(i), v.source(i)].into_iter().for_each(|x| h.bands(x));
        }
    }
}

/// Hashes lights and surroundings.
fn hash_lights(h: &mut WordHasher, scene: &Scene) {
    h.int(scene.lights().len());
    for l in scene.lights() {
        match l {
            Light::Sun { direction, irradiance, angular_diameter, .. } => {
                h.int(0);
                h.vec(*direction);
                h.bands(*irradiance);
                h.real(*angular_diameter);
            }
            Light::Sky { radiance, distribution, .. } => {
                h.int(1);
                h.bands(*radiance);
                distribution.numbers().into_iter().for_each(|x| h.real(x));
                if let Some(picture) = distribution.pixels() {
                    h.int(picture.width);
                    picture.pixels.iter().flatten().for_each(|x| h.real(f64::from(*x)));
                }
            }
            Light::Point { position, intensity, distribution, .. } => {
                h.int(3);
                h.vec(*position);
                h.bands(*intensity);
                distribution.defining_numbers().into_iter().for_each(|x| h.real(x));
            }
            Light::Emitter { surface, .. } => {
                h.int(2);
                h.int(*surface);
            }
        }
    }
    h.bands(scene.surroundings().radiance);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_blake3_of_little_endian_words() {
        let mut h = WordHasher::new();
        let words = || (0..5000u64).map(|i| i * i);
        words().for_each(|w| h.word(w));
        let bytes: Vec<u8> = words().flat_map(u64::to_le_bytes).collect();
        assert_eq!(h.finish(), blake3::hash(&bytes).to_hex().as_str());
        assert!(WordHasher::new().finish().starts_with("af1349b9f5f9a1a6a0404dea36dcc949"));
    }
}
