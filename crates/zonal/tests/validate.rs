//! `zonal validate`: the quick cases hold, a wrong reference is told by the verdict and the exit code, bad options are refused.

mod support;

use std::path::Path;
use support::{Folder, Parser, Program, refused, text};

const REFERENCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");

/// Seconds of cases: closed forms, a slab, a cavity of another solver, laws.
const FAST: &str = "view-factors,fds-*,volumes,cube-areas,layer,gegenbauer,wsgg,openfoam,laws-areas";

#[test]
fn the_fast_cases_hold() {
    let f = Folder::new();
    let out = f.done(&["validate", "--only", FAST, "--json", "--reference", "."]);
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((report["failed"].as_u64(), report["skipped"].as_u64()), (Some(0), Some(0)), "{out}");
    assert!(report["held"].as_u64() > Some(190), "{out}");
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    assert!(cases.iter().all(|c| c["verdict"] == "holds" && c["seconds"].is_number()), "{out}");
    let first = &cases[0]["checks"][0];
    assert_eq!(first["reference"].as_f64(), Some(0.19982489569839));
    assert!((first["ours"].as_f64().unwrap() / 0.19982489569839 - 1.0).abs() < 1e-9);
    assert_eq!(
        (first["limit"]["kind"].as_str(), first["limit"]["value"].as_f64()),
        (Some("relative"), Some(1e-9))
    );
    // Part of the cases writes no page unless one is asked for.
    assert_eq!(f.listing().len(), 1);
}

#[test]
fn a_page_with_plots_and_scenes_that_run() {
    let f = Folder::new();
    let args = ["validate", "--only", "thick-limit,layer", "--output", "out/page", "--scenes", "out/scenes"];
    let out = f.done(&args);
    assert!(out.contains("all 1 hold") && out.contains("extrapolated") && out.contains("order"), "{out}");
    let page = text(&f.get("out/page/validation.md"));
    for part in [
        "# Validation",
        "verdicts hold**",
        "### thick-limit",
        "validation/thick-limit.svg",
        "observed orders",
        "| holds |",
    ] {
        assert!(page.contains(part), "'{part}' is not in\n{page}");
    }
    assert!(text(&f.get("out/page/validation/thick-limit.svg")).contains("orders 1 and 2"));
    f.done(&["check", "out/scenes/layer-1-10.toml"]);
}

/// Two tetrahedra that face each other, all their nodes held at 100 K, in the place of Elmer's mesh: its norm is not met.
fn wrong_mesh(f: &Folder) {
    let folder = "ref/data/thermal-elmer/fem/tests/radiation3d/radiation";
    std::fs::create_dir_all(f.path().join(folder)).unwrap();
    let put = |name: &str, lines: &str| f.put(&format!("{folder}/{name}"), lines);
    put(
        "mesh.nodes",
        "1 -1 0 0 0\n2 -1 1 0 0\n3 -1 0 1 0\n4 -1 0 0 -1\n5 -1 0 0 1\n6 -1 1 0 1\n7 -1 0 1 1\n8 -1 0 0 2\n",
    );
    put("mesh.elements", "1 1 504 1 2 3 4\n2 2 504 5 6 7 8\n");
    let outside = "3 1 1 0 303 1 2 4\n4 1 1 0 303 1 3 4\n5 1 2 0 303 5 6 8\n6 1 2 0 303 5 7 8\n";
    put("mesh.boundary", &format!("1 2 1 0 303 1 2 3\n2 2 2 0 303 5 6 7\n{outside}"));
}

#[test]
fn a_reference_that_is_not_met_ends_with_1() {
    let f = Folder::new();
    wrong_mesh(&f);
    let o = f.zonal(&["validate", "--only", "elmer-cavity,view-factors", "--reference", "ref"]);
    let (out, err) = (text(&o.stdout), text(&o.stderr));
    assert_eq!(o.status.code(), Some(1), "{out}\n{err}");
    assert!(out.contains("FAILS") && out.contains("view-factors") && out.contains("all 16 hold"), "{out}");
    assert_eq!(err.lines().count(), 1, "{err}");
    assert!(err.contains("elmer-cavity"), "{err}");
}

#[test]
fn cases_without_their_files_are_skipped_and_do_not_pass() {
    let f = Folder::new();
    let out = f.done(&["validate", "--only", "mc-c1, elmer-cavity,fds-box,", "--reference", ".", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((report["skipped"].as_u64(), report["held"].as_u64()), (Some(2), Some(10)), "{out}");
    assert_eq!(report["cases"][2]["verdict"], "skipped");
    assert!(report["cases"][2]["skipped"].as_str().unwrap().contains("--reference"), "{out}");
    // Where all were skipped nothing was checked, and that is no success.
    for more in [&["--json"][..], &[]] {
        let o = f.zonal(&[&["validate", "--only", "mc-c1,elmer-cavity", "--reference", "."], more].concat());
        assert_eq!(o.status.code(), Some(1), "{o:?}");
        assert!(text(&o.stderr).contains("nothing was checked"), "{o:?}");
    }
}

#[test]
fn the_list_names_every_case() {
    let f = Folder::new();
    let all = f.done(&["validate", "--list"]);
    for name in ["view-factors", "burns-christon", "furnace", "mc-c10", "elmer-cavity", "laws-solves"] {
        assert!(all.lines().any(|l| l.starts_with(name)), "{name} is not in\n{all}");
    }
    let quick = f.done(&["validate", "--list", "--quick"]);
    assert!(quick.lines().count() < all.lines().count() && !quick.contains("burns-christon"), "{quick}");
    assert_eq!(f.done(&["validate", "--list", "--only", "mc-c*"]).lines().count(), 7);
    assert_eq!(f.listing().len(), 1);
}

#[test]
fn wrong_options_are_refused() {
    let f = Folder::new();
    f.put("taken", "a file");
    refused(&f, Program, &["validate", "--only", "cubes"], "no case is called 'cubes'");
    refused(&f, Program, &["validate", "--only", "a*b*c*d*e*f"], "too many stars");
    refused(&f, Program, &["validate", "--only", " ,"], "no case is named");
    refused(
        &f,
        Program,
        &["validate", "--only", "fds-box", "--reference", "nowhere"],
        "nowhere is no folder",
    );
    refused(&f, Program, &["validate", "--only", "fds-box", "--reference", "taken"], "taken is no folder");
    refused(&f, Program, &["validate", "--only", "burns-christon", "--quick"], "--quick");
    refused(&f, Program, &["validate", "--only", "fds-box", "--output", "taken/x"], "--output");
    refused(&f, Program, &["validate", "--only", "fds-box", "--scenes", "taken/x"], "cannot be made");
    refused(&f, Parser, &["validate", "--nothing"], "--nothing");
}

/// A damaged file of another project is an error that names it.
#[test]
fn damaged_reference_files_are_named() {
    let f = Folder::new();
    wrong_mesh(&f);
    let file = "ref/data/thermal-elmer/fem/tests/radiation3d/radiation/mesh.boundary";
    for broken in ["1 2 1 0 303 1 2 x\n", "1 2 1 0 303 1 2 99\n", "1 2 9 0 303 1 2 3\n", "1 2\n"] {
        f.put(file, broken);
        refused(&f, Program, &["validate", "--only", "elmer-cavity", "--reference", "ref"], "mesh.boundary");
    }
}

/// The Monte Carlo tables, where they are.
#[test]
fn a_monte_carlo_case_holds() {
    if !Path::new(REFERENCE).join("reference/montecarlo").exists() {
        eprintln!("skipped: there is no {REFERENCE}/reference/montecarlo");
        return;
    }
    let f = Folder::new();
    let out = f.done(&["validate", "--only", "mc-c1", "--reference", REFERENCE]);
    assert!(out.contains("all 2 hold"), "{out}");
}
