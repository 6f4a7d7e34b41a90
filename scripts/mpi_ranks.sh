#!/usr/bin/env bash
# mpi_ranks.sh ZONAL ZONAL_MPI FOLDER [quick]: solves scenes on 1, 2, 3, 4 and 7 ranks and compares the bytes with those of one process.
# `quick` takes three scenes on 2 and 3 ranks. Combinations of threads and ranks are among the runs.
set -euo pipefail
zonal=$1 command=$2 folder=$3 quick=${4:-}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
oversubscribe=$(mpirun --version 2>/dev/null | grep -q "Open MPI" && echo --oversubscribe || true)

room() { # name, engine, further lines
    cat >"$folder/$1.toml" <<END
name = "$1"
[solve]
tolerance = 0.1
patch_size = 0.4
engine = "$2"
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [2, 2, 2] }
omit = ["z1"]
reflectance = 0.5
[[surface]]
name = "block"
box = { min = [0.7, 0.6, 0], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }
reflectance = 0.6
[[surface]]
name = "lamp"
rectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }
emission = 10
[[light]]
kind = "emitter"
surface = "lamp"
[surroundings]
radiance = 2
$3
END
}
haze='[medium]
min = [0, 0, 0]
max = [2, 2, 2]
cells = [5, 5, 5]
extinction = 0.4
albedo = 0.5'
sun='[[light]]
kind = "sun"
direction = [0.3, 0.2, -1]
irradiance = 100
angular_diameter = 2'
room rays hierarchical "$haze"
room pairs dense "$haze
$sun"
room open hierarchical "$sun"
cat >"$folder/box.toml" <<END
name = "box"
[solve]
tolerance = 0.01
engine = "spectral"
patch_rule = "voxels"
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [2, 1, 1] }
reflectance = 0.5
faces.z1 = { emission = 10 }
[medium]
min = [0, 0, 0]
max = [2, 1, 1]
cells = [16, 8, 8]
extinction = 0.5
albedo = 0.7
END
cat >"$folder/heat.toml" <<END
name = "heat"
mode = "thermal"
[solve]
tolerance = 0.05
patch_size = 0.5
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [2, 2, 2] }
emissivity = 0.6
temperature = 500
faces.z1 = { temperature = 1200 }
[medium]
min = [0, 0, 0]
max = [2, 2, 2]
cells = [4, 4, 4]
extinction = 0.5
heat_source = 0
END
names=(rays pairs open box heat) counts=(1 2 3 4 7)
[ -z "$quick" ] || counts=(2 3)
failed=0
for name in "${names[@]}"; do
    "$zonal" --quiet solve "$folder/$name.toml" -o "$folder/one.npz" >/dev/null
    for n in "${counts[@]}"; do
        threads=$((n % 2 + 1))
        # shellcheck disable=SC2086
        mpirun $oversubscribe -n "$n" "$command" --quiet --threads "$threads" solve "$folder/$name.toml" -o "$folder/many.npz" >/dev/null
        if cmp -s "$folder/one.npz" "$folder/many.npz"; then
            echo "$name: the same bytes on $n ranks of $threads threads"
        else
            echo "$name: other bytes on $n ranks of $threads threads"
            failed=1
        fi
    done
done
exit $failed
