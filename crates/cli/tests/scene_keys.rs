//! The reference of `zonal keys`.

use crate::support;

use support::{Folder, Program, refused};

#[test]
fn keys_are_listed_in_three_formats() {
    let f = Folder::new();
    let page = f.done(&["keys", "--markdown"]);
    assert!(page.starts_with("# Scene keys\n") && page.contains("| `tolerance` |"), "{page}");
    let list: serde_json::Value = serde_json::from_str(&f.done(&["keys", "--json"])).unwrap();
    let entry = list.as_array().unwrap().iter().find(|k| k["path"] == "solve.scattering_orders").unwrap();
    assert_eq!(entry["type"], "integer from 1");
    let lines = f.done(&["keys"]);
    assert!(lines.contains("\nsolve.tolerance (number in (0, 1); default 0.01): "), "{lines}");
    assert_eq!(lines.lines().count(), list.as_array().unwrap().len());
    refused(&f, Program, &["keys", "--markdown", "--json"], "--markdown");
}
