//! How long relighting takes: a room of smoke with some hundred thousand zones and made-up fields for two lights, read, relit and
//! written, in seconds.
//!
//! ```text
//! cargo run --release --example relight -- FOLDER [CELLS along an edge, 66]
//! ```

use std::path::Path;
use std::time::Instant;
use zonal_io::{input::parse_scene, output};
use zonal_scene::{Bands, Fields, LightGroup, LightGroupKind, Report, Solution, ZoneValues};
use zonal_solve::relight::relight;
use zonal_transport::{Transport, build_zones};

/// A room of `n`³ cells whose smoke differs from cell to cell.
fn solution(n: usize) -> Solution {
    let text = format!(
        "[solve]\npatch_size = {}\n[[surface]]\nname = 'room'\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n\
         [medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = 0.1\n\
         [[light]]\nname = 'sun'\nkind = 'sun'\ndirection = [0,0.6,-0.8]\nirradiance = 100\n\
         [[light]]\nname = 'sky'\nkind = 'sky'\nradiance = 1\n",
        1.5 / n as f64
    );
    let mut parts = parse_scene(&text, None, "room.toml").unwrap_or_else(|e| panic!("{e}")).into_parts();
    if let Some(v) = &mut parts.voxel_grid {
        for i in 0..v.len() {
            v.set(i, Bands::splat(0.1 + (i % 97) as f64), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        }
    }
    parts.voxel_grid = parts.voxel_grid.map(|v| v.seal().unwrap_or_else(|e| panic!("{e}")));
    let scene = zonal_scene::Scene::new(parts).unwrap_or_else(|e| panic!("{e}"));
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap_or_else(|e| panic!("{e}"));
    let value = |k: usize, i: usize| Bands::from_fn(|band| 1.0 / (1 + i * k + band.index()) as f64);
    let field = |k: usize| (0..zones.len()).map(|i| value(k, i)).collect();
    let group = |l: usize, name: &str| LightGroup {
        name: name.into(),
        kind: LightGroupKind::Light(l),
        incident: ZoneValues::Double(field(3 + l)),
        direct: ZoneValues::Double(field(5 + l)),
        ..LightGroup::default()
    };
    let groups = vec![group(0, "sun"), group(1, "sky")];
    let zero: Vec<Bands> = vec![Bands::ZERO; zones.len()];
    let fields = Fields {
        radiosity: zero.clone(),
        incident: field(2),
        direct: zero.clone(),
        error: zero,
        ..Fields::default()
    };
    drop(transport);
    Solution {
        scene,
        zones,
        fields,
        groups,
        report: Report::default(),
        further_blocks: Vec::new(),
        scene_hash: String::new(),
        version: String::new(),
    }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let (folder, n) = (args.next(), args.next().map_or(Ok(66), |n| n.parse()));
    let (Some(folder), Ok(n)) = (folder, n) else {
        eprintln!("relight: give a folder for the files and, if you like, a number of cells");
        std::process::exit(2);
    };
    let (run, out) = (Path::new(&folder).join("run.npz"), Path::new(&folder).join("relit.npz"));
    let s = solution(n);
    output::write_solution(&run, &s).unwrap_or_else(|e| panic!("{e}"));
    println!("{} zones", s.zones.len());
    drop(s);
    for _ in 0..5 {
        let t = Instant::now();
        let s = output::read_solution(&run).unwrap_or_else(|e| panic!("{e}"));
        let read = t.elapsed();
        let mut s = relight(s, &[("sun".into(), Bands::splat(0.2)), ("sky".into(), Bands::splat(3.0))])
            .unwrap_or_else(|e| panic!("{e}"));
        let relit = t.elapsed();
        s.scene_hash = output::scene_hash(&s.scene);
        let signed = t.elapsed();
        output::write_solution(&out, &s).unwrap_or_else(|e| panic!("{e}"));
        println!(
            "read {:.3} s, relit {:.3} s, hashed {:.3} s, written {:.3} s: {:.3} s",
            read.as_secs_f64(),
            (relit - read).as_secs_f64(),
            (signed - relit).as_secs_f64(),
            (t.elapsed() - signed).as_secs_f64(),
            t.elapsed().as_secs_f64()
        );
    }
}
