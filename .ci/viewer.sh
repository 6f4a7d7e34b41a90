#!/usr/bin/env bash
# viewer.sh ZONAL FOLDER: the page of `zonal view`: its sources, its build, and the page in a browser.
source "$(dirname "$0")/common.sh"
zonal=$1 folder=$2

needed=()
command -v chromium >/dev/null || needed+=(chromium)
command -v npm >/dev/null || needed+=(nodejs npm)
if [ ${#needed[@]} -gt 0 ]; then
    install_packages "${needed[@]}" || { missing "${needed[*]} is not available"; exit; }
fi
npm ci --silent --no-audit --no-fund --prefix viewer || { missing "the viewer's npm packages are not available"; exit; }
[ -e "$folder/chapel/chapel.npz" ] || "$zonal" demo chapel --size small -o "$folder/chapel"
npm run --silent --prefix viewer check
npm test --silent --prefix viewer
[ -e "$(dirname "$zonal")/examples/floats" ] || .ci/cargo.sh build --quiet --example floats
BUILT=$(dirname "$zonal") CHAPEL=$folder/chapel/chapel.npz npm run --silent --prefix viewer browser
