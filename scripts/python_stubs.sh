#!/usr/bin/env bash
# python_stubs.sh MATURIN OUTPUT.pyi [ARGUMENT…]: writes the types of the native module of the Python package, from its sources.
#
# The result is committed as python/zonal/_zonal.pyi; CI compares it. pyo3 writes annotations of its own as texts, without imports, and knows no types of
# dictionaries and arrays that Rust code extracts.
set -euo pipefail
maturin=$1 output=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$maturin" generate-stubs --quiet --out "$folder" --manifest-path "$(dirname "$0")/../python/Cargo.toml" --profile dev "$@"
sed -e 's/^from _typeshed import Incomplete, /from _typeshed import /' \
    -e 's/: Incomplete/: Any/g' \
    -e 's/^from typing import /import typing\n\nimport numpy\nimport numpy.typing\nfrom typing import /' \
    -e 's/"\(dict\[str, typing\.Any\]\)"/\1/g' -e 's/"\(numpy\.typing\.[^"]*\)"/\1/g' \
    "$folder/zonal/_zonal.pyi" >"$output"
