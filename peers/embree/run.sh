#!/bin/sh
# Any-hit rates of zonal and of Embree, in turns, on one thread: peers/embree/run.sh [FOLDER] [TURNS]
# Needs libembree-dev (Embree 3), g++ and python3 with numpy. Sponza is used where the shared data lie beside the checkout.
set -eu
cd "$(dirname "$0")/../.."
out=${1:-out/rays}
turns=${2:-3}
mkdir -p "$out"
g++ -O3 -march=native peers/embree/rays.cpp -o "$out/peer" -lembree3
cargo build --release -q -p zonal-benches --bin any_hit
ours=${CARGO_TARGET_DIR:-target}/release/any_hit
obj=../shared/data/sponza-dabrovic/sponza.obj.gz
if [ -e "$obj" ]; then
    python3 peers/embree/triangles.py "$obj" "$out/sponza.raw"
fi
for turn in $(seq "$turns"); do
    "$ours" "$out"
    "$out/peer" "$out" room
    if [ -e "$out/sponza.raw" ]; then
        "$ours" "$out" "$out/sponza.raw"
        "$out/peer" "$out" sponza
    fi
done
