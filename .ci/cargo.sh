#!/usr/bin/env bash
# cargo.sh COMMAND ARGUMENT…: a command of cargo for the packages of CI. One selection gives crates the same features in all steps, so that each is compiled once for
# the tests, the examples, the campaigns and the wheel. Left out are the packages that need MPI and that pull in the tools of benchmarks.
set -euo pipefail
cd "$(dirname "$0")/.."
command=$1
shift
exec cargo "$command" --locked --workspace --exclude zonal-mpi --exclude zonal-benches "$@"
