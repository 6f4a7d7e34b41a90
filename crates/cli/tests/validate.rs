//! `zonal validate`: the quick cases pass, a failed case sets the exit code, wrong options are refused.

use crate::support;

use std::path::Path;
use support::{Folder, Parser, Program, refused, text};

const REFERENCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");

/// Cases of a few seconds: closed forms, a slab, a cavity of another solver, laws.
const FAST_CASES: &str = "view-factors,fds-*,volumes,cube-areas,layer,gegenbauer,wsgg,openfoam,laws-areas";

#[test]
fn fast_cases_pass() {
    let f = Folder::new();
    let out = f.done(&["validate", "--only", FAST_CASES, "--json", "--reference", "."]);
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((report["failed"].as_u64(), report["skipped"].as_u64()), (Some(0), Some(0)), "{out}");
    assert!(report["held"].as_u64() > Some(190), "{out}");
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    assert!(cases.iter().all(|c| c["verdict"] == "pass" && c["seconds"].is_number()), "{out}");
    let first = &cases[0]["checks"][0];
    assert_eq!(first["reference"].as_f64(), Some(0.19982489569839));
    assert!((first["ours"].as_f64().unwrap() / 0.19982489569839 - 1.0).abs() < 1e-9);
    assert_eq!(
        (first["limit"]["kind"].as_str(), first["limit"]["value"].as_f64()),
        (Some("relative"), Some(1e-9))
    );
    // A selection of cases writes no page without --output.
    assert_eq!(f.listing().len(), 1);
}

#[test]
fn page_has_plots_and_valid_scenes() {
    let f = Folder::new();
    let args = ["validate", "--only", "thick-limit,layer", "--output", "out/page", "--scenes", "out/scenes"];
    let out = f.done(&args);
    assert!(out.contains("1/1 pass") && out.contains("extrapolated") && out.contains("order"), "{out}");
    let page = text(&f.get("out/page/validation.md"));
    for part in [
        "# Validation",
        "verdicts pass**",
        "### thick-limit",
        "validation/thick-limit.svg",
        "observed orders",
        "| pass |",
    ] {
        assert!(page.contains(part), "'{part}' is not in\n{page}");
    }
    assert!(text(&f.get("out/page/validation/thick-limit.svg")).contains("orders 1 and 2"));
    f.done(&["check", "out/scenes/layer-1-10.toml"]);
}

/// Writes two facing tetrahedra at 100 K in place of the mesh of Elmer, whose norm they miss.
fn write_wrong_mesh(f: &Folder) {
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

// Guards (files): a missed reference is a failing verdict and exit code 1.
#[test]
fn failed_case_ends_with_1() {
    let f = Folder::new();
    write_wrong_mesh(&f);
    let o = f.zonal(&["validate", "--only", "elmer-cavity,view-factors", "--reference", "ref"]);
    let (out, err) = (text(&o.stdout), text(&o.stderr));
    assert_eq!(o.status.code(), Some(1), "{out}\n{err}");
    assert!(out.contains("FAIL") && out.contains("view-factors") && out.contains("16/16 pass"), "{out}");
    assert_eq!(err.lines().count(), 1, "{err}");
    assert!(err.contains("elmer-cavity"), "{err}");
}

// Guards (files): a validation case without its files is skipped, not passed.
#[test]
fn cases_without_files_are_skipped() {
    let f = Folder::new();
    let out = f.done(&["validate", "--only", "mc-c1, elmer-cavity,fds-box,", "--reference", ".", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((report["skipped"].as_u64(), report["held"].as_u64()), (Some(2), Some(10)), "{out}");
    assert_eq!(report["cases"][2]["verdict"], "skipped");
    assert!(report["cases"][2]["skipped"].as_str().unwrap().contains("--reference"), "{out}");
    // If all cases are skipped, the command fails.
    for more in [&["--json"][..], &[]] {
        let o = f.zonal(&[&["validate", "--only", "mc-c1,elmer-cavity", "--reference", "."], more].concat());
        assert_eq!(o.status.code(), Some(1), "{o:?}");
        assert!(text(&o.stderr).contains("nothing was checked"), "{o:?}");
    }
}

#[test]
fn list_names_every_case() {
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

/// A damaged reference file is an error that names the file.
#[test]
fn damaged_reference_files_are_named() {
    let f = Folder::new();
    write_wrong_mesh(&f);
    let file = "ref/data/thermal-elmer/fem/tests/radiation3d/radiation/mesh.boundary";
    for broken in ["1 2 1 0 303 1 2 x\n", "1 2 1 0 303 1 2 99\n", "1 2 9 0 303 1 2 3\n", "1 2\n"] {
        f.put(file, broken);
        refused(&f, Program, &["validate", "--only", "elmer-cavity", "--reference", "ref"], "mesh.boundary");
    }
}

/// A case with Monte Carlo tables, if these exist.
#[test]
fn monte_carlo_case_passes() {
    if !Path::new(REFERENCE).join("reference/montecarlo").exists() {
        eprintln!("skipped: there is no {REFERENCE}/reference/montecarlo");
        return;
    }
    let f = Folder::new();
    let out = f.done(&["validate", "--only", "mc-c1", "--reference", REFERENCE]);
    assert!(out.contains("2/2 pass"), "{out}");
}
