"""Opens what `zonal demo` wrote with numpy and the standard library alone: check_demo.py FOLDER."""

import json
import struct
import sys
import zlib
from pathlib import Path

import numpy as np

folder = Path(sys.argv[1])


def pixels(path):
    """The pixels of an 8-bit PNG without interlacing, [height, width, channels]."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path}: no PNG"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    assert depth == 8 and interlace == 0 and colour in (0, 2, 6), f"{path}: depth {depth}, colour {colour}"
    n = {0: 1, 2: 3, 6: 4}[colour]
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * n)
    out = np.zeros((height + 1, width * n), np.uint8)
    for y in range(height):
        kind, line, up = raw[y, 0], raw[y, 1:], out[y]
        if kind in (0, 2):
            out[y + 1] = line if kind == 0 else line + up
            continue
        row = [0] * n
        above = [0] * n + [int(v) for v in up]
        for x, v in enumerate(int(v) for v in line):
            a, b, c = row[x], above[x + n], above[x]
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row.append((v + {1: a, 3: (a + b) // 2, 4: paeth}[int(kind)]) & 255)
        out[y + 1] = row[n:]
    return out[1:].reshape(height, width, n)


(solution,) = folder.glob("*.npz")
z = np.load(solution)
header = json.loads(bytes(z["header.json"]))
assert header["format"] == "zonal solution", header["format"]
zones = sum(header["report"]["zones"].values())
for name in ("radiosity", "incident", "direct", "error"):
    assert z[name].shape == (zones, 3), (name, z[name].shape)
    assert np.isfinite(z[name]).all() and (z[name] >= -1e-9 * z[name].max()).all(), name
for name in z.files:
    z[name]  # every array can be read
assert z["radiosity"].max() > 0
residual = np.abs(header["report"]["energy"]["residual"]).max()
assert residual < 1e-3, f"energy residual {residual}"
assert set(header["report"]["status"]) == {"converged"}, header["report"]["status"]
print(f"{solution.name}: {zones} zones, {len(z.files)} arrays, energy residual {residual:.1e}")

pictures = sorted(folder.glob("*.png"))
assert len(pictures) == 2, "the demo has two pictures"
for picture in pictures:
    image, name = pixels(picture).astype(float), picture.stem
    mean, spread = image.mean(), image.std()
    assert 10 < mean < 245 and spread > 10, f"{name}.png looks blank: mean {mean:.1f}, spread {spread:.1f}"
    print(f"{name}.png: {image.shape[1]}×{image.shape[0]}, mean {mean:.0f}, spread {spread:.0f}")

left = [p.name for p in folder.iterdir() if p.name.startswith(".")]
assert not left, f"left behind: {left}"
