#!/usr/bin/env bash
# examples.sh ZONAL: runs the library's examples, as built beside the command by `cargo test`.
source "$(dirname "$0")/common.sh"
folder=$(dirname "$1")/examples
for source in examples/*.rs; do
    name=$(basename "$source" .rs)
    echo "--- $name"
    "$folder/$name"
done
