# Shared by the scripts of the CI steps; sourced, not run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# A missing tool is reported and skipped on a developer's machine, and is a failure on CI.
missing() { # message
    echo "$1"
    [ -z "${CI:-}" ]
}

# Prints the path of a Python in which the packages can be imported; installs them into a virtual environment in the folder where necessary.
python_with() { # folder, packages …
    local folder=$1 python package
    shift
    python=$(command -v python3 || command -v python || true)
    [ -n "$python" ] || return 1
    local imports=true
    for package in "$@"; do
        "$python" -c "import ${package%%[=<>]*}" 2>/dev/null || imports=false
    done
    if ! $imports; then
        [ -x "$folder/venv/bin/python" ] || "$python" -m venv "$folder/venv" || return 1
        python=$folder/venv/bin/python
        for package in "$@"; do
            "$python" -c "import ${package%%[=<>]*}" 2>/dev/null && continue
            "$python" -m pip install --quiet "$package" ||
                "$python" -m pip install --quiet ../shared/"$package"-*.whl || return 1
        done >&2
    fi
    echo "$python"
}
