#!/usr/bin/env bash
# prepare.sh: installs the packages of the steps `python` and `manual` into the shared folder while other steps compile; they install what is missing.
source "$(dirname "$0")/common.sh"
shared_folder
exec 9>"$folder/venv.lock"
if command -v flock >/dev/null; then flock 9; fi
python=$(command -v python3 || true)
if [ -n "$python" ] && "$python" -m venv "$folder/venv"; then
    "$folder/venv/bin/python" -m pip install --quiet "${python_tools[@]}" || true
fi
flock -u 9 2>/dev/null || true
if [ -n "$python" ] && "$python" -m venv "$folder/mkdocs"; then
    "$folder/mkdocs/bin/python" -m pip install --quiet -r docs/requirements.txt || true
fi
