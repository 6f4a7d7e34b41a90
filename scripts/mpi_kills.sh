#!/usr/bin/env bash
# mpi_kills.sh ZONAL ZONAL_MPI SCENE FOLDER [TIMES]: kills one of four ranks at a random moment of a solve with a checkpoint, TIMES times (default 30), and resumes on three.
# Every run must end by itself, with at most one line `error:`, and the resumed solution must have the bytes of an uninterrupted one.
set -euo pipefail
zonal=$1 command=$2 scene=$3 folder=$4 times=${5:-30}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
oversubscribe=$(mpirun --version 2>/dev/null | grep -q "Open MPI" && echo --oversubscribe || true)
mkdir -p "$folder"
start=$(date +%s%N)
"$zonal" --quiet --threads 1 solve "$scene" -o "$folder/one.npz" >/dev/null
whole=$((($(date +%s%N) - start) / 1000000))
failed=0 killed=0
for k in $(seq "$times"); do
    run=$folder/run-$k
    rm -rf "$run".*
    # shellcheck disable=SC2086
    timeout 300 mpirun $oversubscribe -n 4 "$command" --quiet --threads 1 solve "$scene" -o "$run.npz" --checkpoint >/dev/null 2>"$run.log" &
    job=$!
    sleep "$(awk -v w="$whole" -v r="$RANDOM" 'BEGIN { print w * r / 32768 / 1000 }')"
    victims=$(pgrep -f "^$command --quiet --threads 1 solve $scene -o $run.npz" || true)
    victim=$(echo "$victims" | shuf -n 1)
    [ -z "$victim" ] || kill -9 "$victim" 2>/dev/null || true
    code=0
    wait "$job" || code=$?
    lines=$(grep -c "^error:" "$run.log" || true)
    if [ "$code" = 124 ]; then
        echo "$k: hangs"
        failed=1
    elif [ "$code" != 0 ]; then
        killed=$((killed + 1))
        [ "$lines" -le 1 ] || { echo "$k: $lines error lines" && failed=1; }
        [ "$lines" = 1 ] || echo "$k: no error line of zonal"
    fi
    # shellcheck disable=SC2086
    timeout 300 mpirun $oversubscribe -n 3 "$command" --quiet --threads 1 solve "$scene" -o "$run.npz" --resume >/dev/null 2>>"$run.log" ||
        { echo "$k: the resumed solve fails" && failed=1; }
    cmp -s "$folder/one.npz" "$run.npz" || { echo "$k: other bytes" && failed=1; }
done
echo "$killed of $times runs were killed"
exit $failed
