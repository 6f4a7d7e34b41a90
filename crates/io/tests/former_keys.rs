//! Former names of keys: accepted with a warning, refused beside the present name, replaced by the migration.

use zonal_io::input::{migrate_scene_text, parse_scene, scene_key_reference};
use zonal_scene::{BandFractions, LightGrouping, Scene, ZoneBasis};

const BOX: &str = "[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [1, 1, 1]\nextinction = 1\n";

fn read(text: &str) -> Scene {
    parse_scene(text, None, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

/// Scenes with each former key: table, former name, present name, value, and what else the scene needs.
const FORMER: [(&str, &str, &str, &str, &str); 6] = [
    ("solve", "sweeps", "scattering_orders", "3", ""),
    ("solve", "groups", "light_groups", "'each'", ""),
    ("solve", "thick_zones", "zone_basis", "'linear'", ""),
    ("solve", "zoning_error", "discretization_error", "true", ""),
    ("thermal", "shares", "band_fractions", "[0.2, 0.3, 0.5]", "temperature = 900\n"),
    ("thermal", "left_out", "allow_partial", "true", "temperature = 900\n"),
];

/// A scene with one key of a table.
fn scene_text(table: &str, key: &str, value: &str, medium: &str) -> String {
    let mode = if table == "thermal" { "mode = 'thermal'\n" } else { "" };
    let fractions =
        if ["left_out", "allow_partial"].contains(&key) { "band_fractions = [0.2, 0.3, 0.1]\n" } else { "" };
    format!("{mode}[{table}]\n{key} = {value}\n{fractions}{BOX}{medium}")
}

#[test]
fn former_keys_are_read_with_a_warning_that_names_the_present_key() {
    for (table, former, present, value, medium) in FORMER {
        let old = read(&scene_text(table, former, value, medium));
        let new = read(&scene_text(table, present, value, medium));
        assert_eq!(old.options(), new.options());
        assert_eq!(old.thermal(), new.thermal());
        assert!(new.notes().is_empty(), "{:?}", new.notes());
        let [note] = old.notes() else { panic!("{former}: {:?}", old.notes()) };
        assert!(!note.is_warning() && note.code == "renamed-key", "{note:?}");
        assert_eq!(note.location, format!("{table}.{former}"));
        assert!(note.contains(&format!("{table}.{present}")) && note.contains("zonal migrate"), "{note:?}");
    }
}

#[test]
fn former_keys_have_their_values() {
    let s = read(&format!(
        "[solve]\nsweeps = 3\ngroups = 'all'\nthick_zones = 'constant'\nzoning_error = true\n{BOX}"
    ));
    let o = s.options();
    assert_eq!((o.scattering_orders, o.light_grouping), (Some(3), LightGrouping::All));
    assert_eq!((o.zone_basis, o.discretization_error), (ZoneBasis::Constant, Some(true)));
    assert_eq!(s.notes().len(), 4);
    let s = read(&format!(
        "mode = 'thermal'\n[thermal]\nshares = [0.2, 0.3, 0.1]\nleft_out = true\n{BOX}temperature = 900\n"
    ));
    let BandFractions::GreyGases { coefficients, allow_partial, .. } = &s.thermal().unwrap().band_fractions
    else {
        panic!("{:?}", s.thermal())
    };
    assert_eq!((coefficients.as_slice()[2].as_slice(), *allow_partial), (&[0.1][..], true));
}

#[test]
fn a_key_under_both_names_is_refused() {
    for (table, former, present, value, medium) in FORMER {
        let text = scene_text(table, former, value, medium);
        let text = text.replace(&format!("[{table}]\n"), &format!("[{table}]\n{present} = {value}\n"));
        if text.matches("band_fractions").count() > 1 {
            continue;
        }
        let e = parse_scene(&text, None, "test.toml").unwrap_err().to_string();
        assert!(e.contains(&format!("{table}.{former}: this is the former name of '{present}'")), "{e}");
        assert!(migrate_scene_text(&text).is_err());
    }
}

#[test]
fn misspelt_keys_are_corrected_to_present_names_only() {
    let e =
        |key: &str| parse_scene(&format!("[solve]\n{key} = 1\n{BOX}"), None, "t").unwrap_err().to_string();
    assert!(!e("zoning_eror").contains("'zoning_error'"), "{}", e("zoning_eror"));
    assert!(e("scattering_order").contains("did you mean 'scattering_orders'?"));
}

#[test]
fn migrated_scenes_have_no_warnings_and_equal_settings() {
    for (table, former, _, value, medium) in FORMER {
        let text = scene_text(table, former, value, medium);
        let (migrated, changes) = migrate_scene_text(&text).unwrap();
        assert_eq!(changes.len(), 1, "{migrated}");
        let (old, new) = (read(&text), read(&migrated));
        assert!(new.notes().is_empty());
        assert_eq!((old.options(), old.thermal()), (new.options(), new.thermal()));
    }
}

#[test]
fn the_reference_lists_every_key_with_a_description() {
    let keys = scene_key_reference();
    assert!(keys.iter().all(|k| !k.value.is_empty() && !k.description.is_empty()));
    for (table, former, present, ..) in FORMER {
        let key = keys.iter().find(|k| k.path == format!("{table}.{present}")).unwrap();
        assert_eq!(key.former_name, Some(former));
    }
    let paths: std::collections::HashSet<&str> = keys.iter().map(|k| k.path.as_str()).collect();
    assert_eq!(paths.len(), keys.len());
}
