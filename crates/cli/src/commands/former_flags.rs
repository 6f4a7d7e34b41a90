//! Former names of flags, which remain as hidden aliases for one release.

use crate::commands::Command;
use std::ffi::OsString;

/// Former and present names of the flags of `zonal solve`.
const SOLVE_FLAGS: [(&str, &str); 4] = [
    ("--groups", "--light-groups"),
    ("--sweeps", "--scattering-orders"),
    ("--thick-zones", "--zone-basis"),
    ("--zoning-error", "--discretization-error"),
];

/// The former flags among the arguments of a command, each once, with their present names.
pub fn used(
    command: &Command,
    arguments: impl Iterator<Item = OsString>,
) -> Vec<(&'static str, &'static str)> {
    if !matches!(command, Command::Solve(_)) {
        return Vec::new();
    }
    let flags: Vec<String> = arguments
        .take_while(|a| a != "--")
        .map(|a| a.to_string_lossy().split('=').next().unwrap_or("").to_string())
        .collect();
    SOLVE_FLAGS.into_iter().filter(|(former, _)| flags.iter().any(|f| f == former)).collect()
}
