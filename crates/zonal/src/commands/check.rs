//! `zonal check`: is the scene sound, what will it take.

use super::Context;
use crate::Failure;
use crate::failure::say;
use std::path::PathBuf;
use zonal_solve::forecast::{self, Forecast};
use zonal_transport::{Transport, build_zones};

/// Validate a scene, count its zones, forecast time and memory, warn.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).map_err(|e| Failure::in_file(&args.scene, e))?;
    let f = Forecast::new(&scene, &zones, &transport);
    let mut warnings = forecast::warnings(&scene, &zones);
    if forecast::is_open(&scene, &zones, &transport) {
        warnings.push("the scene is open: some rays leave it; its surroundings take part as a zone".into());
    }
    if f.bytes > zonal_solve::pipeline::DEFAULT_MEMORY {
        warnings.push("the exchange areas need more than `solve` takes by default: use larger patches, fewer cells, or --max-memory".into());
    }
    let threads = rayon::current_num_threads();
    let (rays, light) = forecast::direct_light(&scene, &zones, &transport, threads);
    if context.json {
        let json = serde_json::json!({
            "scene": scene.name(), "surfaces": scene.surfaces().len(), "facets": scene.facets().len(),
            "patches": f.patches, "voxel_zones": f.voxels, "cut_voxel_zones": f.cut, "pane_zones": f.panes,
            "pairs": f.pairs, "distinct_bands": f.groups, "memory_bytes": f.bytes, "seconds": f.seconds(threads),
            "zone_bytes": f.zone_bytes, "field_bytes": f.field_bytes, "shadow_rays": rays, "direct_light_seconds": light,
            "occluders": f.occluders, "lights": scene.lights().len(),
            "cameras": scene.cameras().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "warnings": warnings,
        });
        say(&format!("{json:#}"))?;
        return Ok(());
    }
    say(&format!("{}: sound", args.scene.display()))?;
    say(&format!(
        "  {} surfaces, {} facets, {} of which can hide something",
        scene.surfaces().len(),
        scene.facets().len(),
        f.occluders
    ))?;
    say(&format!(
        "  {} patches, {} voxel zones ({} parts of cut voxels), {} pane zones",
        f.patches, f.voxels, f.cut, f.panes
    ))?;
    say(&format!(
        "  {} pairs in {} distinct band(s): about {:.2} GB and {:.0} s on {threads} thread(s)",
        f.pairs,
        f.groups,
        f.bytes as f64 / 1e9,
        f.seconds(threads).max(1.0)
    ))?;
    say(&format!(
        "  besides: zones {:.2} GB, fields {:.2} GB; {:.3e} shadow rays of direct light, {:.0} s",
        f.zone_bytes as f64 / 1e9,
        f.field_bytes as f64 / 1e9,
        rays,
        light
    ))?;
    let cameras: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    say(&format!("  cameras: {}", if cameras.is_empty() { "none".into() } else { cameras.join(", ") }))?;
    for w in warnings {
        say(&format!("  note: {w}"))?;
    }
    Ok(())
}
