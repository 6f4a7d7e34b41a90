"""stand_ins.py FILE …: small files under the names that the pages use, in the present folder: hall.glb, lamp.ies, smoke.vdb, city.stl."""

from __future__ import annotations

import json
import os
import shutil
import struct
import sys
from pathlib import Path

ROOT = Path(os.environ["ZONAL_ROOT"])


def glb(path: Path, materials: list[str]) -> None:
    """A model of one square for each material, side by side, 2 m apart; y is up."""
    corners = [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]]
    points = [[x + 2 * k, y, z] for k in range(len(materials)) for x, y, z in corners]
    data = b"".join(struct.pack("<3f", *p) for p in points) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    n = len(materials)
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 48 * n}, {"buffer": 0, "byteOffset": 48 * n, "byteLength": 12}]
    accessors = [{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]
    for k in range(n):
        low, high = [2 * k, 0, 0], [2 * k + 1, 0, 1]
        accessors.append({"bufferView": 0, "byteOffset": 48 * k, "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": k + 1}, "indices": 0, "material": k} for k in range(n)]}],
        "materials": [{"name": m, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}} for m in materials],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = data + b"\0" * (-len(data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def ies(path: Path) -> None:
    """A photometric file of a lamp of 100 cd in all directions."""
    angles = [0, 45, 90, 135, 180]
    lines = ["IESNA:LM-63-2002", "TILT=NONE", f"1 1000 1 {len(angles)} 1 1 2 0 0 0", "1 1 10"]
    lines += [" ".join(map(str, angles)), "0", " ".join(["100"] * len(angles))]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def stl(path: Path) -> None:
    """Two squares that face each other, as text."""
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    lines = ["solid city"]
    for z, order in ((0, (0, 1, 2, 0, 2, 3)), (1, (0, 2, 1, 0, 3, 2))):
        for k in (0, 3):
            corners = [f"vertex {square[i][0]} {square[i][1]} {z}" for i in order[k : k + 3]]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid city"]) + "\n", encoding="ascii")


def main() -> None:
    for name in sys.argv[1:]:
        path = Path(name)
        if path.suffix == ".glb":
            glb(path, ["brick", "glass", "lamp", "people"])
        elif path.suffix == ".ies":
            ies(path)
        elif path.suffix == ".vdb":
            shutil.copy(ROOT / "crates/io/tests/data/mixed.vdb", path)
        elif path.suffix == ".stl":
            stl(path)
        else:
            sys.exit(f"{name}: there is no such stand-in")


if __name__ == "__main__":
    main()
