//! Former flags and keys: aliases with notes, `zonal migrate`, and the reference of `zonal keys`.

use crate::support;

use support::{Folder, Parser, Program, ROOM, refused, text};

const FORMER_KEYS: &str = "[solve] # settings\ngroups = 'all' # one group\nsweeps = 3\n";
const PRESENT_KEYS: &str = "[solve] # settings\nlight_groups = 'all' # one group\nscattering_orders = 3\n";

#[test]
fn former_flags_are_aliases_with_one_note() {
    let f = Folder::new();
    f.put("room.toml", ROOM);
    let solve = |output: &str, flags: &[&str]| {
        let o = f.zonal(&[&["solve", "room.toml", "-o", output], flags].concat());
        assert!(o.status.success(), "{flags:?}: {}", text(&o.stderr));
        text(&o.stderr)
    };
    for (former, present, value) in [
        ("--groups", "--light-groups", "all"),
        ("--thick-zones", "--zone-basis", "constant"),
        ("--zoning-error", "--discretization-error", "false"),
        ("--sweeps", "--scattering-orders", "2"),
    ] {
        let note = format!("note: {former} is now {present}\n");
        assert_eq!(solve("former.npz", &[former, value]), note);
        assert_eq!(solve("former.npz", &[&format!("{former}={value}")]), note);
        assert_eq!(solve("present.npz", &[present, value]), "");
        assert_eq!(f.get("former.npz"), f.get("present.npz"), "{former}");
        let help = f.done(&["solve", "--help"]);
        assert!(help.contains(present) && !help.contains(&format!("{former} ")), "{former} is in the help");
    }
    // Values of other commands are not former flags.
    let o = f.zonal(&["export", "present.npz", "-o", "out/x.glb", "--light-groups"]);
    assert!(o.status.success() && o.stderr.is_empty(), "{}", text(&o.stderr));
    refused(&f, Parser, &["check", "room.toml", "--groups", "all"], "--groups");
}

#[test]
fn migrate_prints_changes_and_writes_on_request() {
    let f = Folder::new();
    f.put("old.toml", FORMER_KEYS);
    let preview = f.done(&["migrate", "old.toml"]);
    assert!(preview.contains("old.toml:2: solve.groups -> solve.light_groups\n"), "{preview}");
    assert!(preview.contains("old.toml:3: solve.sweeps -> solve.scattering_orders\n"), "{preview}");
    assert!(preview.contains("2 key(s) to rename"), "{preview}");
    assert_eq!(text(&f.get("old.toml")), FORMER_KEYS);
    let written = f.done(&["migrate", "old.toml", "--write"]);
    assert!(written.contains("2 key(s) renamed; written: old.toml"), "{written}");
    assert_eq!(text(&f.get("old.toml")), PRESENT_KEYS);
    assert!(f.done(&["migrate", "old.toml", "--write"]).contains("no former keys"));
    assert_eq!(text(&f.get("old.toml")), PRESENT_KEYS);
    f.put("old.toml", FORMER_KEYS);
    let report: serde_json::Value =
        serde_json::from_str(&f.done(&["migrate", "old.toml", "--write", "--json"])).unwrap();
    assert_eq!((&report["written"], &report["changes"][0]["line"]), (&true.into(), &2.into()));
    assert_eq!(report["changes"][1]["new"], "solve.scattering_orders");
    // A folder out and the scene: no temporary files.
    assert_eq!(f.listing().len(), 2);
}

#[test]
fn migrate_refuses_files_that_are_no_scenes() {
    let f = Folder::new();
    f.put("both.toml", "[solve]\nsweeps = 2\nscattering_orders = 3\n");
    f.put("broken.toml", "[solve");
    f.put("latin.toml", b"name = 'caf\xe9'");
    for flags in [&[][..], &["--write"]] {
        for (file, named) in [
            ("both.toml", "both.toml:2:1: solve.sweeps"),
            ("broken.toml", "broken.toml:1:"),
            ("latin.toml", "latin.toml"),
            ("none.toml", "none.toml"),
            ("out", "out"),
        ] {
            refused(&f, Program, &[&["migrate", file], flags].concat(), named);
        }
    }
    refused(&f, Parser, &["migrate"], "<SCENE>");
}

#[test]
fn keys_are_listed_in_three_formats() {
    let f = Folder::new();
    let page = f.done(&["keys", "--markdown"]);
    assert!(page.starts_with("# Scene keys\n") && page.contains("| `tolerance` |"), "{page}");
    let list: serde_json::Value = serde_json::from_str(&f.done(&["keys", "--json"])).unwrap();
    let entry = list.as_array().unwrap().iter().find(|k| k["path"] == "solve.scattering_orders").unwrap();
    assert_eq!(entry["former_name"], "sweeps");
    let lines = f.done(&["keys"]);
    assert!(lines.contains("\nsolve.tolerance (number in (0, 1); default 0.01): "), "{lines}");
    assert_eq!(lines.lines().count(), list.as_array().unwrap().len());
    refused(&f, Program, &["keys", "--markdown", "--json"], "--markdown");
}
