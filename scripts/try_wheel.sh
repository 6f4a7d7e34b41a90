#!/usr/bin/env bash
# try_wheel.sh WHEEL: installs a wheel where there is neither Rust nor a compiler, and runs the Python code of the README there.
#
# As root and with debootstrap, the place is a Debian system with Python alone, which is made once and kept below target/packages; DEBIAN names its release,
# bookworm by default. Otherwise it is a virtual environment whose programs are the only ones on the path. numpy comes from its registry.
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$wheel" "$work"
# The first block of Python in the README.
awk '/^```python$/ { inside = !seen; next } /^```$/ { seen = seen || inside; inside = 0 } inside' README.md >"$work/readme.py"
cat >"$work/try.sh" <<'END'
set -eu
cd "$1"
for tool in cc gcc clang cargo rustc; do
    if command -v "$tool"; then echo "error: $tool is on the path"; exit 1; fi
done
echo "C library: $(python -c 'import platform; print(*platform.libc_ver())')"
begin=$(python -c 'import time; print(time.time())')
python -m pip install --quiet --only-binary :all: ./*.whl
python -c "import time; print(f'installed in {time.time() - $begin:.1f} s')"
python readme.py
zonal --version
END

debian=${DEBIAN:-bookworm}
system=${CARGO_TARGET_DIR:-target}/packages/debian-$debian
if [ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null; then
    if [ ! -e "$system/usr/bin/python3" ]; then
        echo "makes a Debian system in $system"
        rm -rf "$system"
        mkdir -p "$system"
        debootstrap --variant=minbase --include=python3,python3-venv,ca-certificates "$debian" "$system" >/dev/null
    fi
    mkdir -p "$system/try"
    cp "$work"/* "$system/try"
    # Certificates of this machine, where it has some of its own.
    if [ -e /etc/ssl/certs/ca-certificates.crt ]; then cp /etc/ssl/certs/ca-certificates.crt "$system/etc/ssl/certs"; fi
    cp /etc/resolv.conf "$system/etc/resolv.conf"
    chroot "$system" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/root LANG=C.UTF-8 \
        ${https_proxy:+https_proxy="$https_proxy"} ${PIP_INDEX_URL:+PIP_INDEX_URL="$PIP_INDEX_URL"} PIP_CERT=/etc/ssl/certs/ca-certificates.crt \
        sh -c 'rm -rf /venv && python3 -m venv /venv && PATH=/venv/bin:$PATH exec sh /try/try.sh /try'
    rm -rf "$system/try" "$system/venv"
else
    echo "no root or no debootstrap: an empty virtual environment"
    "$(command -v python3 || command -v python)" -m venv "$work/venv"
    # dash and coreutils may lie beside compilers, so the path has the environment alone.
    env -i PATH="$work/venv/bin" HOME="$work" LANG=C.UTF-8 ${https_proxy:+https_proxy="$https_proxy"} ${PIP_INDEX_URL:+PIP_INDEX_URL="$PIP_INDEX_URL"} \
        ${PIP_CERT:+PIP_CERT="$PIP_CERT"} "$(command -v sh)" "$work/try.sh" "$work"
fi
