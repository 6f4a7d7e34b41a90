//! The gas of Smith, Shen and Friedman with its clear window in radiative equilibrium between walls, against discrete ordinates.

use crate::common;

use common::{read, solve};
use zonal_reference::slab::{Slab, SlabBand, SlabCondition};
use zonal_scene::Solution;

/// Layers of both programs; and of discrete ordinates for one layer of the spectral engine, which is refined beyond the limit of 0.1 %.
const LAYERS: usize = 120;
const REFERENCE_LAYERS_PER_LAYER: usize = 2;

/// The engines, with the layers of discrete ordinates for each of theirs and the largest relative difference. The layered engine has uniform layers too.
const ENGINES: [(&str, (usize, f64)); 2] =
    [("layered", (1, 1e-6)), ("spectral", (REFERENCE_LAYERS_PER_LAYER, 1e-3))];

/// A slab of 2 m by an engine, with the lines of its walls and its medium.
fn slab(engine: &str, walls: &str, heat: f64) -> Solution {
    solve(read(&format!(
        "mode = \"thermal\"\n[solve]\nengine = \"{engine}\"\npatch_rule = \"voxels\"\nresidual = 1e-11\ndiscretization_error = false\n[boundary]\nx = \"periodic\"\ny = \"periodic\"\n[[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = [1,1,2] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\n{walls}\n[medium]\nmin = [0,0,0]\nmax = [1,1,2]\ncells = [1, 1, {LAYERS}]\nheat_source = {heat}\ngas = {{ model = \"wsgg-smith-1982\", h2o = 0.2, co2 = 0.1 }}\n"
    )))
}

/// Compares temperatures and wall fluxes with discrete ordinates in `parts` layers for each of the solution.
fn assert_equilibrium(
    s: &Solution,
    (parts, limit): (usize, f64),
    emissivity: [f64; 2],
    heat: f64,
    walls: [SlabCondition; 2],
) {
    let layers = parts * LAYERS;
    assert_eq!(s.scene.bands().count(), 4);
    let blocks: Vec<_> = s.scene.blocks().collect();
    let extinction = |b: usize| blocks[b / 3].voxel_grid().unwrap().extinction(0).to_rgb()[b % 3];
    let fractions = |b: usize, t: f64| {
        blocks[b / 3].thermal().unwrap().band_fractions.grey_gas_weights(t).to_rgb()[b % 3]
    };
    assert!((0..4).any(|b| extinction(b) == 0.0) && extinction(3).max(extinction(2)) > 10.0);
    let band = |b: usize| SlabBand {
        extinction: vec![extinction(b); layers],
        albedo: vec![0.0; layers],
        wall_emissivity: emissivity,
    };
    let slab = Slab { thickness: vec![2.0 / layers as f64; layers], bands: (0..4).map(band).collect() };
    let conditions = vec![SlabCondition::NetPower(heat); layers];
    let want = slab.equilibrium(&conditions, walls, &|_, b, t| fractions(b, t)).unwrap();
    let exact = |cell: usize| {
        let own = &want.layer_temperatures[parts * cell..parts * (cell + 1)];
        (own.iter().map(|t| t.powi(4)).sum::<f64>() / parts as f64).powf(0.25)
    };
    let field = s.fields.heat.as_ref().unwrap();
    for (i, v) in s.zones.voxels.iter().enumerate() {
        let [ours, exact] = [field.temperature[s.zones.voxel_offset() + i], exact(v.cell)];
        assert!((ours / exact - 1.0).abs() < limit, "layer {}: {ours} K, {exact} K", v.cell);
    }
    let rows = &s.report.heat.as_ref().unwrap().rows;
    for (k, name) in ["d.z0", "d.z1"].iter().enumerate() {
        let row = rows.iter().find(|r| r.name == *name).unwrap();
        let flux = zonal_reference::slab::total_flux(&want.bands);
        let exact = if k == 0 { flux[0] } else { -flux[layers] };
        let scale = flux.iter().fold(0.0f64, |m, q| m.max(q.abs()));
        assert!((row.power - exact).abs() < limit * scale, "{name}: {} W/m², {exact} W/m²", row.power);
        let kelvin = row.temperature.unwrap();
        assert!((kelvin / want.wall_temperatures[k] - 1.0).abs() < limit, "{name}: {kelvin} K");
    }
    assert!(s.report.heat.as_ref().unwrap().balance().abs() < 1e-5 * 1e5);
}

#[test]
fn gas_in_radiative_equilibrium_between_black_and_grey_walls() {
    for emissivity in [[1.0, 1.0], [0.8, 0.5]] {
        let walls = format!(
            "emissivity = {}\ntemperature = 1500\nfaces.z1 = {{ temperature = 700, emissivity = {} }}",
            emissivity[0], emissivity[1]
        );
        let conditions = [SlabCondition::Temperature(1500.0), SlabCondition::Temperature(700.0)];
        for (engine, accuracy) in ENGINES {
            assert_equilibrium(&slab(engine, &walls, 0.0), accuracy, emissivity, 0.0, conditions);
        }
    }
}

#[test]
fn gas_with_a_source_above_an_adiabatic_wall() {
    for emissivity in [[1.0, 1.0], [0.8, 0.5]] {
        let walls = format!(
            "emissivity = {}\ntemperature = 800\nfaces.z1 = {{ heat_flux = 0, emissivity = {} }}",
            emissivity[0], emissivity[1]
        );
        let conditions = [SlabCondition::Temperature(800.0), SlabCondition::NetPower(0.0)];
        for (engine, accuracy) in ENGINES {
            assert_equilibrium(&slab(engine, &walls, 2e4), accuracy, emissivity, 2e4, conditions);
        }
    }
}
