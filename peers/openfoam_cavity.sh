#!/usr/bin/env bash
# The net radiative fluxes of crates/validation/src/validate/data/openfoam.csv: OpenFOAM (1912, Debian's package `openfoam`) on the case
# ../shared/data/thermal-openfoam, whose walls keep the temperatures of its start. The flow is put to rest: one step of 10 ns without gravity.
# Writes the field qr of that step to standard output; its patches hot, cold, top, Bottom are the walls x1, x0, y1, y0.
set -euo pipefail
case=${1:-$(dirname "$0")/../../shared/data/thermal-openfoam}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -rL "$case/." "$work"
chmod -R u+w "$work"
cd "$work"
export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam} FOAM_SIGFPE=false
sed -i -e 's/^application.*/application buoyantPimpleFoam;/' -e 's/^endTime .*/endTime 1e-8;/' -e 's/^deltaT .*/deltaT 1e-8;/' \
    -e 's/^writeInterval.*/writeInterval 1;/' -e 's/^timePrecision.*/timePrecision 12;/' -e 's/^writePrecision.*/writePrecision 10;/' \
    -e '/^functions/,$d' system/controlDict
sed -i 's/(0  *-9.81 0)/(0 0 0)/' constant/g
# A perfect gas at 1 bar in place of a Boussinesq fluid at pressure 0; radiation does not see it.
sed -i -e 's/Boussinesq/perfectGas/' -e 's/sensibleInternalEnergy/sensibleEnthalpy/' constant/thermophysicalProperties
sed -i 's/uniform 0;/uniform 1e5;/' 0/p 0/p_rgh
sed -i -e 's/pRefValue .*/pRefValue 1e5;/' -e 's/nOuterCorrectors 5/nOuterCorrectors 1/' -e 's/nCorrectors     5/nCorrectors 0/' \
    -e 's/momentumPredictor yes/momentumPredictor no/' system/fvSolution
faceAgglomerate >&2
viewFactorsGen >&2
buoyantPimpleFoam >&2
cat 1e-08/qr
