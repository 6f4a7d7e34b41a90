#!/usr/bin/env python3
"""packages.py [list | crates | sdist | wheel | publish]…: makes the packages of a release and tries them; without a word crates, sdist and wheel, in half an hour.

    list     the files of each crate's package, and whether they suffice; compiles nothing
    crates   the .crate files; builds the command from them alone, outside the repository, and draws a demo
    sdist    the source distribution; pip builds and installs it in an empty environment
    wheel    the wheel for old systems of Linux: size, contents, tag; installs it where there is no compiler, and runs the code of the README
    publish  publishes the crates in the order of dependencies, for the checklist in docs/releases.md alone. It continues after a stop: crates that the registry
             has are passed over, and it waits where the registry wants fewer new crates at a time. `cargo publish --workspace` does neither.

Packages lie in target/packages. The tools of Python come from its registry, into target/packages/venv.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
OUT = TARGET / "packages"
# Largest wheel, bytes.
MAX_WHEEL = 12_000_000
# Oldest C library of the wheel: that of the oldest systems for which Rust compiles.
MANYLINUX = "manylinux_2_17"
# Seconds until the registry takes one more new crate.
WAIT_FOR_REGISTRY = 630
TOOLS = ["maturin>=1.13,<2", "ziglang"]
LICENCES = ["LICENSE-MIT", "LICENSE-APACHE"]
IN_CRATES = re.compile(r"(src|viewer)/|LICENSE-|README\.md$|Cargo\.(toml|toml\.orig|lock)$|\.cargo_vcs_info\.json$")
EMBEDDED = re.compile(r'include_(?:str|bytes)!\(\s*"([^"]+)"\s*\)')


def run(command, folder=ROOT, **options):
    print("   ", *(str(c) for c in command), flush=True)
    begin = time.monotonic()
    subprocess.run([str(c) for c in command], cwd=folder, check=True, **options)
    seconds = time.monotonic() - begin
    print(f"    {seconds:.0f} s", flush=True)


def metadata():
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)["packages"]


def published():
    """Packages of the workspace that go to the registry, all without `publish = false`, each after those on which it depends."""
    rest = {p["name"]: p for p in metadata() if p["publish"] is None}
    ordered = []
    while rest:
        needs = {n: {d["name"] for d in p["dependencies"] if d["name"] in rest} for n, p in rest.items()}
        ready = [n for n in rest if not needs[n]]
        if not ready:
            sys.exit(f"error: {', '.join(rest)} depend on each other")
        ordered += [rest.pop(n) for n in ready]
    return ordered


def list_of_files(name):
    command = ["cargo", "package", "--locked", "--allow-dirty", "--quiet", "--list", "--package", name]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\n")[:-1]


def violations(package, files, names):
    """What is wrong with the package of a crate."""
    found = [f"{f} is missing" for f in ["Cargo.toml", "README.md", *LICENCES] if f not in files]
    found += [f"{f} belongs to no package" for f in files if not IN_CRATES.match(f)]
    for d in package["dependencies"]:
        if d.get("path") and d["kind"] != "dev":
            if d["name"] not in names:
                found.append(f"it depends on {d['name']}, which is not published")
            if d["req"] != f"={package['version']}":
                found.append(f"it depends on {d['name']} {d['req']}, expected ={package['version']}")
    folder = pathlib.Path(package["manifest_path"]).parent
    for f in files:
        if f.endswith(".rs") and "tests" not in f:
            for name in EMBEDDED.findall((folder / f).read_text(encoding="utf-8").split("#[cfg(test)]")[0]):
                file = pathlib.Path(os.path.normpath(folder / f / ".." / name))
                if not file.is_relative_to(folder) or file.relative_to(folder).as_posix() not in files:
                    found.append(f"{f} embeds {name}, which is not in the package")
    return found


def check_lists():
    packages = published()
    names = {p["name"] for p in packages}
    failed = 0
    keys = ["description", "license", "readme", "keywords", "categories"]
    # The address of the repository is known with the first release.
    keys += ["repository"] if any(p["repository"] for p in packages) else []
    for p in packages:
        files = list_of_files(p["name"])
        found = violations(p, files, names) + [f"the key {key} is missing" for key in keys if not p[key]]
        failed += bool(found)
        print(f"{p['name']:<20} {len(files):>4} files")
        for text in found:
            print(f"    {text}")
    if failed:
        sys.exit(f"error: {failed} packages have faults")


def make_crates():
    packages = published()
    begin = time.monotonic()
    words = [word for p in packages for word in ("--package", p["name"])]
    run(["cargo", "package", "--locked", "--allow-dirty", "--no-verify", "--quiet", *words])
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        patches = ["[patch.crates-io]"]
        for p in packages:
            name = f"{p['name']}-{p['version']}"
            archive = TARGET / "package" / f"{name}.crate"
            shutil.copy(archive, OUT)
            with tarfile.open(archive) as content:
                content.extractall(folder, filter="data")
                sizes = [m.size for m in content.getmembers()]
            print(f"{p['name']:<20} {len(sizes):>4} files {sum(sizes) / 1e3:>6.0f} kB, packed {archive.stat().st_size / 1e3:>5.0f} kB")
            patches.append(f'{p["name"]} = {{ path = "{name}" }}')
        (folder / ".cargo").mkdir()
        (folder / ".cargo/config.toml").write_text("\n".join(patches) + "\n")
        version = packages[0]["version"]
        # Quick to compile; the speed of the demo matters little.
        environment = {**os.environ, "CARGO_TARGET_DIR": str(folder / "target"), "CARGO_PROFILE_DEV_OPT_LEVEL": "1", "CARGO_PROFILE_DEV_DEBUG": "false"}
        for name, verb in (("zonal-cli", "build"), ("zonal", "check")):
            run(["cargo", verb, "--quiet"], folder / f"{name}-{version}", env=environment)
        run([folder / "target/debug/zonal", "demo", "chapel", "--size", "small", "-o", folder / "demo"], folder, stdout=subprocess.DEVNULL)
    print(f"crates: {time.monotonic() - begin:.0f} s")


def tools():
    """A virtual environment with maturin, first on the path."""
    venv = OUT / "venv"
    if not (venv / "bin/maturin").exists():
        run([sys.executable, "-m", "venv", venv])
        run([venv / "bin/python", "-m", "pip", "install", "--quiet", *TOOLS])
    return {**os.environ, "PATH": f"{venv / 'bin'}{os.pathsep}{os.environ['PATH']}"}


def fresh(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def make_sdist():
    out = fresh(OUT / "sdist")
    run(["maturin", "sdist", "--manifest-path", "python/Cargo.toml", "--out", out], env=tools())
    archive = next(out.iterdir())
    with tarfile.open(archive) as content:
        members = [m for m in content.getmembers() if m.isfile()]
    print(f"{archive.name}: {len(members)} files {sum(m.size for m in members) / 1e6:.1f} MB, packed {archive.stat().st_size / 1e6:.1f} MB")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        run([sys.executable, "-m", "venv", folder / "venv"])
        pip = [folder / "venv/bin/python", "-m", "pip", "install", "--quiet"]
        run([*pip, archive], folder, env={k: v for k, v in os.environ.items() if k != "CARGO_TARGET_DIR"})
        run([folder / "venv/bin/zonal", "--version"], folder)


def make_wheel():
    out = fresh(OUT / "wheel")
    words = ["--locked", "--quiet", "--zig", "--compatibility", MANYLINUX]
    run(["maturin", "build", *words, "--manifest-path", "python/Cargo.toml", "--out", out], env=tools())
    wheel = next(out.iterdir())
    size = wheel.stat().st_size
    with zipfile.ZipFile(wheel) as content:
        infos = content.infolist()
    print(f"{wheel.name}: {len(infos)} files {sum(i.file_size for i in infos) / 1e6:.1f} MB, packed {size / 1e6:.2f} MB")
    names = [i.filename for i in infos]
    wanted = ["zonal/py.typed", "zonal/_zonal.pyi", *(f"licenses/{f}" for f in [*LICENCES, "THIRD-PARTY-LICENSES.md"])]
    missing = [w for w in wanted if not any(n == w or n.endswith(f".dist-info/{w}") for n in names)]
    if missing:
        sys.exit(f"error: the wheel lacks {', '.join(missing)}")
    if MANYLINUX not in wheel.name or "abi3" not in wheel.name:
        sys.exit(f"error: the tag of the wheel is not abi3 and {MANYLINUX}")
    if size > MAX_WHEEL:
        sys.exit(f"error: the wheel has {size / 1e6:.1f} MB, more than {MAX_WHEEL / 1e6:.0f} MB")
    run(["scripts/try_wheel.sh", wheel])


def publish():
    for p in published():
        command = ["cargo", "publish", "--locked", "--no-verify", "--package", p["name"]]
        while True:
            done = subprocess.run(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
            if done.returncode == 0:
                print(f"{p['name']} {p['version']} is published", flush=True)
            elif "already exists" in done.stderr or "already uploaded" in done.stderr:
                print(f"{p['name']} {p['version']} was there already", flush=True)
            elif "429" in done.stderr:
                print(f"{p['name']}: the registry takes no more crates for now; the next attempt follows in {WAIT_FOR_REGISTRY / 60:.0f} minutes", flush=True)
                time.sleep(WAIT_FOR_REGISTRY)
                continue
            else:
                sys.exit(done.stderr)
            break


PARTS = {"list": check_lists, "crates": make_crates, "sdist": make_sdist, "wheel": make_wheel, "publish": publish}


def main():
    parts = sys.argv[1:] or ["list", "crates", "sdist", "wheel"]
    if unknown := [p for p in parts if p not in PARTS]:
        sys.exit(f"error: there is no part {unknown[0]}; parts are {', '.join(PARTS)}")
    OUT.mkdir(parents=True, exist_ok=True)
    try:
        for part in parts:
            PARTS[part]()
    except subprocess.CalledProcessError as e:
        sys.exit(f"error: {' '.join(map(str, e.cmd))} failed: {(e.stderr or b'').decode(errors='replace') if isinstance(e.stderr, bytes) else e.stderr or e.returncode}")


if __name__ == "__main__":
    main()
