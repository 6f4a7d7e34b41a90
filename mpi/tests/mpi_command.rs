//! The command by itself: one rank, without mpirun.

#[test]
fn the_command_names_its_subcommands() {
    let out = std::process::Command::new(env!("CARGO_BIN_EXE_zonal-mpi")).arg("--help").output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(out.status.success() && text.contains("solve") && text.contains("render"), "{text}");
}
