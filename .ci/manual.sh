#!/usr/bin/env bash
# manual.sh ZONAL FOLDER: the generated pages are up to date, the site builds, and its internal links resolve.
source "$(dirname "$0")/common.sh"
zonal=$1 folder=$2

"$zonal" keys --markdown >"$folder/scene-keys.md"
diff -u docs/reference/scene-keys.md "$folder/scene-keys.md"
venv=$folder/mkdocs
python=$(command -v python3 || true)
if [ -z "$python" ] || ! "$python" -m venv "$venv" || ! "$venv/bin/python" -m pip install --quiet -r docs/requirements.txt; then
    missing "mkdocs is not available"
    exit
fi
"$venv/bin/mkdocs" build --quiet --strict --site-dir "$folder/site"
