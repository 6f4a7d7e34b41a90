#!/usr/bin/env bash
# mpi.sh ZONAL: the command zonal-mpi: lint, tests, and solutions with the bytes of one process on several ranks.
source "$(dirname "$0")/common.sh"
zonal=$1
if ! command -v mpicc >/dev/null && [ -n "${CI:-}" ]; then
    install_packages --no-install-recommends libopenmpi-dev openmpi-bin libclang-dev || true
fi
if ! command -v mpicc >/dev/null || ! command -v mpirun >/dev/null; then
    missing "no MPI with mpicc and mpirun is available"
    exit
fi

# The packages of the other steps are named with it, so that crates have the same features and are not compiled again.
cargo clippy --quiet --locked --workspace --bin zonal-mpi --test mpi_command -- -D warnings
cargo test --quiet --locked --workspace --exclude zonal-benches --bin zonal-mpi --test mpi_command
python3 scripts/mpi_runs.py ranks --quick --zonal "$zonal" --mpi "$(dirname "$zonal")/zonal-mpi"
