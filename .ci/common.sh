# Shared by the scripts of the CI steps; sourced, not run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# A missing tool is reported and skipped on a developer's machine, and is a failure on CI.
missing() { # message
    echo "$1"
    [ -z "${CI:-}" ]
}

# Installs packages of the system where that is possible, one step at a time.
install_packages() { # option or package …
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 1
    (
        if command -v flock >/dev/null; then flock 8; fi
        apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "$@" >/dev/null
    ) 8>"${TMPDIR:-/tmp}/zonal-ci-packages.lock"
}

# Packages of the tests of the Python package.
python_tools=(maturin numpy pytest mypy pyright tqdm pandas xarray meshio trimesh pyvista scipy matplotlib fdsreader)

# The folder that all steps of one CI run share, or one of this script, which is removed at its end.
shared_folder() {
    folder=${ZONAL_CI_FOLDER:-}
    if [ -z "$folder" ]; then
        folder=$(mktemp -d)
        trap 'rm -rf "$folder"' EXIT
    fi
}

# Prints the path of a Python in which the packages can be imported; installs them into the virtual environment of the folder where necessary.
python_with() { # folder, packages …
    local folder=$1 python package
    shift
    if [ -x "$folder/venv/bin/python" ]; then
        PATH=$folder/venv/bin:$PATH
    fi
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
