#!/bin/bash
# Runs fuzz targets one after the other, each for a number of executions: fuzz/run.sh COUNT [TARGET ...]
#
#   fuzz/run.sh 100000                every target
#   fuzz/run.sh 500000 vdb npz        these two
#
# Needs `cargo install cargo-fuzz --locked` and a C++ compiler; the stable toolchain will do. New inputs go to $FUZZ_OUT/corpus, inputs that
# fail to $FUZZ_OUT/artifacts, what libFuzzer says to $FUZZ_OUT/log (FUZZ_OUT: target/fuzz). A target that fails ends the script
# with 1 when all have run. SEED, MAX_TIME (seconds a target) and JOBS (threads of one execution) may be set.
set -u
cd "$(dirname "$0")" || exit 2
count=${1:?how many executions of each target?}
shift
if [ $# -eq 0 ]; then
    set -- $(basename -s .rs fuzz_targets/*.rs)
fi
out=${FUZZ_OUT:-$PWD/target/fuzz}
mkdir -p "$out/log"
export RAYON_NUM_THREADS=${JOBS:-1}
host=$(rustc -vV | sed -n 's/^host: //p')
bin=${CARGO_TARGET_DIR:-target}/$host/release
cargo fuzz build --fuzz-dir . -s none "${FUZZ_BUILD:---release}" || exit 2
failed=0
for target in "$@"; do
    mkdir -p "$out/corpus/$target" "$out/artifacts/$target"
    options=(-runs="$count" -seed="${SEED:-1}" -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=512 -max_len=4096 -print_final_stats=1
        -reload=0 -artifact_prefix="$out/artifacts/$target/")
    case $target in
        vdb) options+=(-max_len=40000 -len_control=0) ;;
        npz) options+=(-max_len=24000 -len_control=0) ;;
        gltf | init | msh | obj | ply | stl | view3d | vtk | exr) options+=(-max_len=8192) ;;
        solve) options+=(-max_len=256 -timeout=60) ;;
    esac
    [ -f "dict/$target.dict" ] && options+=(-dict="dict/$target.dict")
    [ -n "${MAX_TIME:-}" ] && options+=(-max_total_time="$MAX_TIME")
    folders=("$out/corpus/$target")
    for kept in "corpus/$target" "findings/$target"; do
        [ -d "$kept" ] && folders+=("$kept")
    done
    "$bin/$target" "${options[@]}" "${folders[@]}" > "$out/log/$target.log" 2>&1
    code=$?
    runs=$(sed -n 's/^stat::number_of_executed_units: //p' "$out/log/$target.log")
    echo "$target: ${runs:-?} executions, exit code $code"
    [ $code -ne 0 ] && failed=1
done
exit $failed
