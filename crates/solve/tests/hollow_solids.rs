//! Hollow solids: separate enclosures have separate heat balances.
//!
//! Guards (numbers): the two sides of a hollow solid belong to separate enclosures, each with its own heat balance.

use crate::common;

use common::solve;
use zonal_math::{Vec3, vec3};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{
    Bands, Facet, NoProgress, Plate, Scene, SceneParts, Solution, Surface, Thermal, ThermalCondition,
};

/// 80 triangles of a sphere, normals outward.
fn sphere(radius: f64) -> Vec<Plate> {
    let phi = 0.5 * (1.0 + 5f64.sqrt());
    let corners: Vec<Vec3> = [-1.0, 1.0]
        .into_iter()
        .flat_map(|a| [-phi, phi].into_iter().map(move |b| (a, b)))
        .flat_map(|(a, b)| [vec3(0.0, a, b), vec3(a, b, 0.0), vec3(b, 0.0, a)])
        .collect();
    let mut out = Vec::new();
    let near = |a: Vec3, b: Vec3| ((a - b).length() - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in 0..i {
            for k in 0..j {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                if !(near(a, b) && near(b, c) && near(c, a)) {
                    continue;
                }
                let (b, c) = if a.dot(b.cross(c)) > 0.0 { (b, c) } else { (c, b) };
                let [x, y, z] = [a + b, b + c, c + a];
                let on = |p: Vec3| p.normalized() * radius;
                for [p, q, r] in [[a, x, z], [b, y, x], [c, z, y], [x, y, z]] {
                    out.push(Plate::triangle(on(p), on(q), on(r)));
                }
            }
        }
    }
    assert_eq!(out.len(), 80);
    out
}

/// Spherical surfaces with name, radius, whether they face inwards, temperature (K) and emissivity.
fn shells(list: &[(&str, f64, bool, f64, f64)]) -> (Scene, Vec<f64>) {
    let mut parts = SceneParts { thermal: Some(Thermal::default()), ..SceneParts::default() };
    parts.options.patch_size = Some(10.0);
    let mut areas = Vec::new();
    for (k, &(name, radius, inward, kelvin, emissivity)) in list.iter().enumerate() {
        parts.surfaces.push(Surface {
            name: name.into(),
            reflectance: Bands::splat(1.0 - emissivity),
            solid: !inward,
            ..Surface::default()
        });
        parts.thermal.as_mut().unwrap().surfaces.push(ThermalCondition::Temperature(kelvin));
        let plates = sphere(radius);
        areas.push(plates.iter().map(Plate::area).sum());
        let looking = |p: &Plate| if inward { p.flipped() } else { *p };
        let facets = plates.iter().map(|p| Facet { surface: k, plate: looking(p), uv: [[0.0; 2]; 3] });
        parts.facets.extend(facets);
    }
    (Scene::new(parts).unwrap(), areas)
}

fn power(s: &Solution, name: &str) -> f64 {
    s.report.heat.as_ref().unwrap().rows.iter().find(|r| r.name == name).expect("a row").power
}

/// A body at 600 K in a shield at 400 K in a room at 300 K: two enclosures of two grey surfaces each,
///
/// ```text
///     Q = (E₁ − E₂) / ((1−ε₁)/(ε₁A₁) + 1/A₁ + (1−ε₂)/(ε₂A₂))
/// ```
#[test]
fn double_skinned_shield_separates_two_enclosures() {
    let (scene, a) = shells(&[
        ("inner", 0.5048, false, 600.0, 0.8),
        ("inside", 0.7572, true, 400.0, 0.05),
        ("outside", 0.7573, false, 400.0, 0.05),
        ("outer", 1.0095, true, 300.0, 0.5),
    ]);
    let s = solve(scene);
    let between = |t: [f64; 2], e: [f64; 2], a: [f64; 2]| {
        let rest = |k: usize| (1.0 - e[k]) / (e[k] * a[k]);
        (blackbody_emissive_power(t[0]) - blackbody_emissive_power(t[1])) / (rest(0) + 1.0 / a[0] + rest(1))
    };
    let first = between([600.0, 400.0], [0.8, 0.05], [a[0], a[1]]);
    let second = between([400.0, 300.0], [0.05, 0.5], [a[2], a[3]]);
    for (name, want) in [("inner", first), ("inside", -first), ("outside", second), ("outer", -second)] {
        let q = power(&s, name);
        assert!((q / want - 1.0).abs() < 0.02, "{name}: {q} W, {want} W by the closed form");
    }
}

#[test]
fn hot_body_inside_another_is_refused_by_name() {
    let (scene, _) = shells(&[("inner", 0.5, false, 600.0, 0.8), ("outer", 1.0, false, 300.0, 0.5)]);
    let e = zonal_solve::solve(scene, 1 << 30, &NoProgress).unwrap_err();
    assert!(e.key().contains("'inner'") && e.message().contains("'outer'"), "{} {}", e.key(), e.message());
}
