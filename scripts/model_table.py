#!/usr/bin/env python3
"""Draws model files from nothing but the files, and writes a table of what happened.

    scripts/model_table.py [--zonal target/release/zonal] [--pictures DIR] [-o table.md] MODEL ...

Each model has a scene by `zonal init`, a draft (`zonal solve --quality draft`) and a picture of its first camera. The table has the seconds of
each step, the zones, the largest stated error, and a verdict: drawn, blank (the picture has one colour), or refused with the message, which names a
remedy. Exit code 1 if a picture is blank, a command fails after the scene was written, or a refusal gives no remedy. Python 3 without packages.
"""

import argparse
import json
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

# Words of messages that say what to do.
REMEDIES = ("convert", "give", "export", "write", "use ", "choose", "add ", "--", "remove", "install")


def run(arguments):
    """Exit code, standard output, last line of standard error, seconds."""
    start = time.monotonic()
    done = subprocess.run(arguments, capture_output=True, text=True, errors="replace", check=False)
    lines = [line for line in done.stderr.splitlines() if line.startswith("error")]
    return done.returncode, done.stdout, lines[-1] if lines else "", time.monotonic() - start


def spread(path):
    """Range of the bytes of a picture, an 8-bit PNG without its filters undone: 0 for a picture of one colour, whose rows have one or no value."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        packed += data[at + 8 : at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return len(set(zlib.decompress(packed)))


def draw(zonal, model, folder, pictures):
    """A row of the table, and whether it is as it should be."""
    name = model.stem
    scene, solution = folder / "scene.toml", folder / "run.npz"
    picture = (pictures or folder) / f"{model.suffix[1:].lower()}-{name}.png"
    row = {"file": model.name, "format": model.suffix[1:].lower(), "bytes": model.stat().st_size}
    code, out, error, seconds = run([zonal, "--quiet", "--json", "init", model, "-o", scene])
    row["init"] = seconds
    if code != 0:
        row["verdict"] = f"refused: {error.removeprefix('error: ').replace(str(model), model.name)}"
        return row, any(word in error for word in REMEDIES)
    row["faces"] = json.loads(out).get("faces")
    code, out, error, row["solve"] = run([zonal, "--quiet", "--json", "solve", scene, "--quality", "draft", "-o", solution])
    if code != 0:
        row["verdict"] = f"solve failed: {error}"
        return row, False
    report = json.loads(out)
    row["zones"] = sum(report["zones"].values())
    estimate = report["estimate"]
    errors = [e for kind in ("patches", "volumes") for e in estimate.get(kind) or [] if isinstance(e, (int, float))]
    row["error"] = max(errors, default=None)
    code, _, error, row["render"] = run([zonal, "--quiet", "render", solution, "--size", "480x320", "-o", picture])
    if code != 0:
        row["verdict"] = f"render failed: {error}"
        return row, False
    row["verdict"] = "drawn" if spread(picture) > 8 else "blank"
    return row, row["verdict"] == "drawn"


def line(row):
    def number(key, form):
        return form.format(row[key]) if row.get(key) is not None else ""

    cells = [row["file"], number("faces", "{:,}").replace(",", " "), number("init", "{:.1f}"), number("solve", "{:.1f}")]
    cells += [number("render", "{:.1f}"), number("zones", "{:,}").replace(",", " "), number("error", "{:.2f}")]
    return "| " + " | ".join([*cells, row["verdict"].replace("|", "\\|")]) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--zonal", default="target/release/zonal")
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    heading = ["model", "faces", "init, s", "draft, s", "picture, s", "zones", "stated error", "verdict"]
    table, bad = ["| " + " | ".join(heading) + " |", "|---" * len(heading) + "|"], 0
    for model in options.models:
        with tempfile.TemporaryDirectory() as folder:
            row, good = draw(options.zonal, model.resolve(), Path(folder), options.pictures)
        bad += not good
        table.append(line(row))
        print(table[-1], flush=True)
    if options.output:
        options.output.write_text("\n".join(table) + "\n", encoding="utf-8")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
