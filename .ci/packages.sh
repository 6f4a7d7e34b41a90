#!/usr/bin/env bash
# packages.sh: packages of a release without compiling them: equal versions, files of each crate's package, and the workflow of releases.
#
# Guards (structure): the package of each published crate holds its sources, its embedded files and both licences, and depends on published crates alone.
source "$(dirname "$0")/common.sh"
cargo xtask version
python=$(command -v python3 || true)
[ -n "$python" ] || { missing "Python is not available"; exit; }
"$python" scripts/packages.py list

shared_folder
venv=$folder/workflows
# The schema of workflows, and rules on permissions, injection and credentials; neither tool needs the network.
if ! "$python" -m venv "$venv" || ! "$venv/bin/python" -m pip install --quiet "check-jsonschema>=0.33" "zizmor>=1.11"; then
    missing "check-jsonschema and zizmor are not available"
    exit
fi
"$venv/bin/check-jsonschema" --builtin-schema vendor.github-workflows .github/workflows/*.yml
"$venv/bin/zizmor" --quiet --no-progress --offline --config .github/zizmor.yml .github/workflows
