#!/usr/bin/env bash
# python_package.sh ZONAL: the Python package, built and tested in a virtual environment of its own.
#
# The wheel of the test build (optimised as the tests are), its types against the committed ones, pytest with every example of the docstrings and the Python
# block of the README, pyright in strict mode, stubtest, and the licences of the crates in the wheel.
# Guards (python): the types of the native module and the reference of the package are generated, and examples of docstrings run.
source "$(dirname "$0")/common.sh"
zonal=$1
shared_folder
python=$(command -v python3 || true)
# Wait for the packages that are being installed.
exec 9>"$folder/venv.lock"
if command -v flock >/dev/null; then flock 9; fi
if [ -z "$python" ] || ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    ! { [ -x "$folder/venv/bin/python" ] || "$python" -m venv "$folder/venv"; } ||
    ! "$folder/venv/bin/python" -m pip install --quiet "${python_tools[@]}"; then
    missing "Python 3.11 with ${python_tools[*]} is not available"
    exit
fi
bin=$folder/venv/bin

echo "licences of the crates in the wheel"
python3 scripts/third_party.py --check
echo "types of the native module"
scripts/python_stubs.sh "$bin/maturin" "$folder/_zonal.pyi" --locked
diff -u python/zonal/_zonal.pyi "$folder/_zonal.pyi"
echo "wheel"
"$bin/maturin" build --quiet --locked --profile dev --manifest-path python/Cargo.toml --out "$folder/dist"
"$bin/python" -m pip install --quiet "$folder"/dist/zonal-*.whl
echo "reference page"
"$bin/python" scripts/python_reference.py "$folder/python.md"
diff -u docs/reference/python.md "$folder/python.md"
# The types are checked while the tests run.
"$bin/pyright" --pythonpath "$bin/python" --project python >"$folder/pyright.log" 2>&1 &
pyright=$!
echo "pytest"
# Away from the sources, so that the installed package is tested.
mkdir "$folder/run" && cp -r python/tests python/pyproject.toml "$folder/run"
package=$("$bin/python" -c 'import os, zonal; print(os.path.dirname(zonal.__file__))')
(cd "$folder/run" && ZONAL=$zonal ZONAL_ROOT=$OLDPWD "$bin/python" -m pytest --quiet --doctest-modules tests "$package")
echo "pyright, stubtest"
wait "$pyright" || { cat "$folder/pyright.log"; exit 1; }
tail -1 "$folder/pyright.log"
(cd "$folder/run" && "$bin/python" -m mypy.stubtest zonal._zonal)
