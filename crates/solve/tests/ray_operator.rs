//! The exchange operator by rays: closure, opaque walls, panes, and continued paths.
//!
//! Guards (numbers): no ray passes a wall; continued paths resolve shadows within a patch and keep an isothermal enclosure uniform.

use crate::common;

use common::{mean, patches_of, read, sheet_over_floor, unit_room, with_site};
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_scene::{Band, Bands, NoProgress, Scene};
use zonal_solve::ExchangeOperator;
use zonal_solve::distribution::Execution;
use zonal_solve::engines::rays::ray_operator::{PathContinuation, RayOperator};
use zonal_solve::right_hand_side::surroundings::SurroundingsExchange;

const GAS: &str = "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [8,8,8]\nextinction = 1\nalbedo = 0.8\n";

#[test]
fn rows_of_rays_close_and_walls_are_opaque() {
    // An oblique sheet across the whole room: no light arrives below it.
    const CEILING: &str = "[[surface]]\nname = \"sheet\"\nrectangle = { origin = [0,0,0.4], edge1 = [1,0,0.11], edge2 = [0,1,0.07] }\nreflectance = 0.5\nsides = \"both\"\n";
    let scene =
        read(&unit_room("patch_size = 0.125", "faces.z1 = { emission = 1 }", &format!("{GAS}{CEILING}")));
    with_site(&scene, |context, surroundings| {
        let zones = context.zones;
        let mut operator = RayOperator::new(context, [32, 16], PathContinuation::On);
        let ones: Vec<Bands> = (0..zones.len()).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        for (i, p) in operator.apply(&ones).iter().enumerate() {
            let want = closure_target(zones, i);
            assert!((p.first() / want - 1.0).abs() < 1e-5, "{i}: {} of {want}", p.first());
        }
        let lit = operator.solve(context, surroundings).swap_remove(0);
        let columns = operator.gathered_power(&[lit]);
        let above = |x: f64, y: f64, z: f64| z - (0.4 + 0.11 * x + 0.07 * y);
        let mut dark = 0;
        for (i, p) in zones.patches.iter().enumerate() {
            let c = p.plate.centre() + p.normal * 1e-3;
            if above(c.x, c.y, c.z) < 0.0
                && (0..4).all(|k| {
                    let q = p.plate.corners().0[k.min(p.plate.corners().1 - 1)];
                    above(q.x, q.y, q.z) < 1e-9
                })
            {
                assert_eq!(columns[0][i], Bands::ZERO, "patch {i}");
                dark += 1;
            }
        }
        assert!(dark > 50, "{dark}");
    });
}

/// A room with a pane in its middle, grey or coloured.
fn glazed(extinction: &str) -> Scene {
    let pane = format!(
        "[[pane]]\npolygon = [[0.5,0,0],[0.5,1,0],[0.5,1,1],[0.5,0,1]]\nthickness = 0.01\nextinction = {extinction}\nalbedo = 0.6\n"
    );
    let walls = "reflectance = 0.5\nfaces.x0 = { emission = 1 }";
    read(&format!(
        "{}{GAS}{pane}",
        unit_room(
            "patch_size = 0.25\ntolerance = 0.003\nengine = \"dense\"\nclosure = \"measure\"",
            walls,
            ""
        )
    ))
}

#[test]
fn rows_of_a_room_with_a_pane_close() {
    with_site(&glazed("100"), |context, _| {
        let zones = context.zones;
        let operator = RayOperator::new(context, [64, 64], PathContinuation::Off);
        let ones: Vec<Bands> = (0..zones.len()).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        for (i, p) in operator.apply(&ones).iter().enumerate() {
            let want = closure_target(zones, i);
            assert!((p.first() / want - 1.0).abs() < 1e-5, "{i}: {} of {want}", p.first());
        }
    });
}

#[test]
fn panes_absorb_rays_and_emit_rays() {
    let scene = glazed("[30, 100, 300]");
    let dense = common::solve(scene.clone());
    with_site(&scene, |context, surroundings| {
        let zones = context.zones;
        let mut operator = RayOperator::new(context, [2048, 2048], PathContinuation::Off);
        let strengths = operator.solve(context, surroundings);
        let columns = operator.gathered_power(&strengths);
        let patches = |side: bool| {
            let of = |i: &usize| (zones.patches[*i].plate.centre().x > 0.5) == side;
            (0..zones.voxel_offset()).filter(of).collect::<Vec<_>>()
        };
        let panes: Vec<usize> = (zones.pane_offset()..zones.len()).collect();
        for (what, list) in [("lit", patches(false)), ("behind", patches(true)), ("pane", panes)] {
            for b in Band::all() {
                let measure = |i: usize| zones.response(i).1;
                let ours: f64 =
                    list.iter().map(|&i| columns.iter().map(|c| c[i][b]).sum::<f64>() / measure(i)).sum();
                let want: f64 = list.iter().map(|&i| dense.fields.incident[i][b]).sum();
                assert!((ours / want - 1.0).abs() < 0.012, "{what}, {b:?}: {ours} against {want}");
            }
        }
    });
}

/// H of every patch by exchange with other zones, W/m².
fn irradiance(scene: &Scene, rays: usize, continuation: PathContinuation) -> Vec<f64> {
    let mut out = Vec::new();
    with_site(scene, |context, surroundings| {
        let mut operator = RayOperator::new(context, [rays, rays], continuation);
        let strengths = operator.solve(context, surroundings);
        let columns = operator.gathered_power(&strengths);
        let whole = |i: usize| columns.iter().map(|c| c[i].first()).sum::<f64>();
        out = (0..context.zones.patches.len()).map(|i| whole(i) / context.zones.patches[i].area).collect();
    });
    out
}

#[test]
fn continued_rays_resolve_the_shadow_below_a_sheet() {
    // Small patches of the floor resolve the shadow; a single patch does not, unless rays continue from the point hit.
    let fine = common::solve(sheet_over_floor("0.04"));
    let below = |s: &zonal_scene::Solution| -> Vec<usize> {
        patches_of(s, "sheet").into_iter().filter(|&i| s.zones.patches[i].normal.z < 0.0).collect()
    };
    let reference = mean(&fine, &fine.fields.incident, &below(&fine));
    let scene = sheet_over_floor("0.8");
    let coarse = common::solve(scene.clone());
    let under = below(&coarse);
    let of = |h: Vec<f64>| under.iter().map(|&i| h[i]).sum::<f64>() / under.len() as f64;
    let by_rays = |continuation| of(irradiance(&scene, 1024, continuation));
    let (plain, continued) = (by_rays(PathContinuation::Off), by_rays(PathContinuation::On));
    let dense = mean(&coarse, &coarse.fields.incident, &under);
    assert!(
        (plain / dense - 1.0).abs() < 0.05,
        "rays without continuation agree with the dense engine: {plain} {dense}"
    );
    assert!(plain > 1.5 * reference, "{plain} {reference}");
    assert!((continued / reference - 1.0).abs() < 0.06, "{continued} {reference}");
}

#[test]
fn continued_rays_keep_an_isothermal_enclosure_uniform() {
    // A closed enclosure of one temperature: B = 1 wherever a ray continues.
    let walls = "reflectance = 0.6\nemission = 0.4\npatch_size = 0.25";
    let block = "[[surface]]\nname = \"block\"\nbox = { min = [0.45,0.3,0.01], max = [0.7,0.6,0.6] }\nreflectance = 0.3\nemission = 0.7\n";
    let scene = read(&unit_room("patch_size = 0.125", walls, block));
    for (i, h) in irradiance(&scene, 64, PathContinuation::On).into_iter().enumerate() {
        assert!((h - 1.0).abs() < 5e-3, "patch {i}: {h}");
    }
}

#[test]
fn a_gather_measures_the_surroundings_through_panes() {
    // A skylight of two triangles over a coloured pane, and an open corner of the skylight: rays leave through one pane, two panes or none.
    const PANES: &str = "[[pane]]\npolygon = [[0,0,1],[1,0,1],[1,0.8,1],[0,0.8,1]]\nthickness = 0.01\nextinction = [50,100,0]\n\
        [[pane]]\npolygon = [[0.1,0.1,0.6],[0.6,0.1,0.6],[0.6,0.9,0.6],[0.1,0.9,0.6]]\nthickness = 0.01\nextinction = [10,20,90]\n";
    let sky = "[surroundings]\nradiance = [2,1,3]\n";
    let scene = read(&unit_room(
        "patch_size = 0.25\ntolerance = 0.02",
        "omit = [\"z1\"]\nreflectance = 0.5",
        &format!("{PANES}{GAS}{sky}"),
    ));
    with_site(&scene, |context, _| {
        let (zones, transport) = (context.zones, context.transport);
        let wanted =
            SurroundingsExchange::measure(zones, transport, 4096, 0, Execution::alone(&NoProgress), None);
        let operator = RayOperator::new(context, [32, 16], PathContinuation::On);
        let radiosity = scene.surroundings().radiosity();
        for share in [1.0, 0.5, 0.0] {
            let found = operator.gathered_surroundings(vec![share; zones.len()]);
            for range in [
                0..zones.voxel_offset(),
                zones.voxel_offset()..zones.pane_offset(),
                zones.pane_offset()..zones.len(),
            ] {
                let (mut apart, mut whole) = (Bands::ZERO, Bands::ZERO);
                for i in range {
                    let exact = wanted.incoming(i, radiosity)[0] / zones.response(i).1;
                    apart += (found[i] - exact).map(|d| d * d);
                    whole += exact * exact;
                }
                let error = apart.zip_map(whole, |a, w| (a / w).sqrt()).max_element();
                println!("share {share}: {error:.4}");
                assert!(error < 0.03, "share {share}: {error}");
            }
        }
    });
}
