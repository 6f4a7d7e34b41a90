#!/usr/bin/env bash
# python.sh PACKAGES SCRIPT ARGUMENT…: runs a Python script that needs packages (a list separated by spaces).
source "$(dirname "$0")/common.sh"
packages=$1
shift
shared_folder
# shellcheck disable=SC2086
python=$(python_with "$folder" $packages) || { missing "Python with $packages is not available"; exit; }
"$python" "$@"
