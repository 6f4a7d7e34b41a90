#!/usr/bin/env python3
"""archive.py TARGET [--out FOLDER] [--try]: the archive of the command `zonal` for a target of the compiler.

The program is the one that `cargo build --profile dist --package zonal-cli --target TARGET` made. The archive has the program, the licences of zonal and of all
crates in it, the changelog, and the bill of materials in CycloneDX (`cargo install --locked cargo-cyclonedx`). Names follow the key
package.metadata.binstall in crates/cli/Cargo.toml, by which `cargo binstall` finds the archive. --try unpacks it and draws a small demo.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tarfile
import tempfile
import zipfile

import third_party

ROOT = pathlib.Path(__file__).resolve().parents[1]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
COPIED = ["LICENSE-MIT", "LICENSE-APACHE", "CHANGELOG.md"]
SUFFIXES = {"tgz": ".tgz", "zip": ".zip"}


def names(target):
    """File name of the archive, and place of the program in it."""
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"]
    packages = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)["packages"]
    package = next(p for p in packages if p["name"] == "zonal-cli")
    keys = package["metadata"]["binstall"]
    suffix = SUFFIXES[keys.get("overrides", {}).get(target, {}).get("pkg-fmt", keys["pkg-fmt"])]
    values = {"version": package["version"], "target": target, "archive-suffix": suffix, "bin": "zonal", "binary-ext": ".exe" if "windows" in target else ""}

    def filled(template):
        for key, value in values.items():
            template = template.replace(f"{{ {key} }}", value)
        return template

    return filled(keys["pkg-url"].rsplit("/", 1)[1]), filled(keys["bin-dir"])


def bill_of_materials(target, path):
    """Writes the crates of the command for a target, in CycloneDX."""
    manifest = ROOT / "crates/cli/Cargo.toml"
    name = "zonal-bill-of-materials"
    command = ["cargo", "cyclonedx", "--quiet", "--manifest-path", manifest, "--format", "json", "--target", target, "--no-build-deps", "--spec-version", "1.5", "--override-filename", name]
    subprocess.run(command, cwd=ROOT, check=True)
    # The tool writes one file into the folder of each package that it describes.
    text = (manifest.parent / f"{name}.json").read_text(encoding="utf-8")
    # Without the folder of the build.
    path.write_text(text.replace(ROOT.as_uri(), "file:///zonal"), encoding="utf-8")
    for rest in [*ROOT.glob(f"*/{name}.json"), *ROOT.glob(f"crates/*/{name}.json")]:
        rest.unlink()


def try_archive(archive, program):
    with tempfile.TemporaryDirectory() as folder:
        shutil.unpack_archive(archive, folder, "zip" if archive.suffix == ".zip" else "gztar", filter=None if archive.suffix == ".zip" else "data")
        command = pathlib.Path(folder) / program
        for words in (["--version"], ["demo", "chapel", "--size", "small", "-o", pathlib.Path(folder) / "demo"]):
            subprocess.run([command, *words], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("target")
    parser.add_argument("--out", type=pathlib.Path, default=TARGET / "packages")
    parser.add_argument("--try", action="store_true", dest="tried")
    given = parser.parse_args()
    name, program = names(given.target)
    given.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        folder = (pathlib.Path(work) / program).parent
        folder.mkdir()
        built = TARGET / given.target / "dist" / pathlib.PurePosixPath(program).name
        shutil.copy(built, folder)
        for file in COPIED:
            shutil.copy(ROOT / file, folder)
        text = third_party.text("zonal-cli", [given.target])
        (folder / "THIRD-PARTY-LICENSES.md").write_text(text, encoding="utf-8")
        bill_of_materials(given.target, folder / "zonal.cdx.json")
        archive = given.out / name
        files = sorted(folder.iterdir())
        if archive.suffix == ".zip":
            with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as content:
                for file in files:
                    content.write(file, f"{folder.name}/{file.name}")
        else:
            with tarfile.open(archive, "w:gz") as content:
                for file in files:
                    content.add(file, f"{folder.name}/{file.name}")
        for file in files:
            print(f"{file.name:<28} {file.stat().st_size / 1e3:>7.0f} kB")
        print(f"{archive.name}: {len(files)} files, packed {archive.stat().st_size / 1e6:.1f} MB")
    if given.tried:
        try_archive(archive, program)


if __name__ == "__main__":
    main()
