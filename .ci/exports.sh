#!/usr/bin/env bash
# exports.sh ZONAL FOLDER: the demo's solution and a textured room, exported and read by VTK and by the glTF validator.
# Guards (files): a GLB contains the walls of the scene and is valid (glTF validator in CI).
source "$(dirname "$0")/common.sh"
zonal=$1 folder=$2

[ -e "$folder/chapel/chapel.npz" ] || "$zonal" demo chapel --size small -o "$folder/chapel"
cat >"$folder/painted.toml" <<-'END'
	[[surface]]
	name = "painted"
	room = { min = [0, 0, 0], max = [2, 3, 1] }
	texture = "chapel/nave.png"
	[[surface]]
	name = "lamp"
	rectangle = { origin = [0.5, 0.5, 0.9], edge1 = [0, 0.5, 0], edge2 = [0.5, 0, 0] }
	emission = 100
END
"$zonal" solve "$folder/painted.toml" -o "$folder/painted.npz"
"$zonal" export "$folder/painted.npz" -o "$folder/painted.glb" --light-groups
"$zonal" export "$folder/painted.npz" -o "$folder/mapped.glb" --lightmap --atlas 256
for extension in glb vti; do
    "$zonal" export "$folder/chapel/chapel.npz" -o "$folder/chapel.$extension"
done
"$zonal" export "$folder/chapel/chapel.npz" -o "$folder/chapel.vtu" --points
"$zonal" export "$folder/chapel/chapel.npz" -o "$folder/volume.npz" --irradiance-volume --grid 12,16,12
.ci/python.sh "numpy vtk" .ci/check_export.py "$folder/chapel/chapel.npz" "$folder"/chapel.{vtu,vti,medium.npz} "$folder/volume.npz"
if command -v npm >/dev/null && npm install --silent --prefix "$folder/node" gltf-validator@2.0.0-dev.3.10; then
    NODE_PATH="$folder/node/node_modules" node .ci/check_glb.cjs "$folder"/{chapel,painted,mapped}.glb
else
    missing "the glTF validator is not available"
fi
