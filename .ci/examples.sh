#!/usr/bin/env bash
# examples.sh ZONAL: builds and runs the library's examples; their folder is beside the command.
#
# They are chosen by name among all default members: with `--package` the features of some dependencies differ from those of the tests, and most crates are
# compiled again.
source "$(dirname "$0")/common.sh"
names=()
for source in examples/*.rs; do names+=("$(basename "$source" .rs)"); done
.ci/cargo.sh build --quiet "${names[@]/#/--example=}"
folder=$(dirname "$1")/examples
for name in "${names[@]}"; do
    echo "--- $name"
    "$folder/$name"
done
