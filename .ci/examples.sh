#!/usr/bin/env bash
# examples.sh ZONAL: builds and runs the library's examples; their folder is beside the command.
source "$(dirname "$0")/common.sh"
cargo build --quiet --locked --package zonal --examples
folder=$(dirname "$1")/examples
for source in examples/*.rs; do
    name=$(basename "$source" .rs)
    echo "--- $name"
    "$folder/$name"
done
