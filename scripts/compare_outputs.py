#!/usr/bin/env python3
"""Compares what two builds of `zonal` write: compare_outputs.py OLD NEW [--keep FOLDER] [--only NAME]

Runs both binaries on the same small scenes (all engines, both modes, every output) and compares the bytes of every numeric array of an
.npz, the pixels of .exr and .png, the binary buffers of .glb and .vtu/.vti, and the numbers of .csv. Keys of JSON, hashes, versions,
times and the compression of containers are no part of the comparison. Needs numpy. Exit code 1 where anything differs.
"""

import argparse
import io
import re
import struct
import subprocess
import sys
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np

BOX = """
[solve]
tolerance = 0.01
patch_rule = "voxels"
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [2, 3, 2.5] }
reflectance = [0.7, 0.5, 0.3]
faces.z1 = { reflectance = 0.2, emission = [90, 80, 70] }
[medium]
min = [0, 0, 0]
max = [2, 3, 2.5]
cells = [4, 6, 5]
extinction = [0.4, 0.5, 0.9]
albedo = [0.9, 0.8, 0.6]
[[camera]]
name = "room"
origin = [1.8, 2.8, 1.4]
target = [0.4, 0.6, 1]
fov = 70
"""

LIGHTS = """
[[light]]
kind = "sun"
name = "sun"
direction = [0.5, 0.3, -1]
irradiance = [900, 850, 700]
[surroundings]
name = "sky"
radiance = [10, 12, 16]
"""

OPEN = """
[solve]
tolerance = 0.05
patch_size = 0.6
light_groups = "each"
[[surface]]
name = "floor"
rectangle = { origin = [0, 0, 0], edge1 = [3, 0, 0], edge2 = [0, 3, 0] }
reflectance = 0.5
[[surface]]
name = "wall"
rectangle = { origin = [0, 0, 0], edge1 = [0, 3, 0], edge2 = [0, 0, 2] }
sides = "both"
reflectance = [0.6, 0.3, 0.2]
[[surface]]
name = "block"
box = { min = [1, 1, 0.2], max = [1.7, 2, 1], rotate_z_degrees = 25 }
reflectance = 0.4
[[camera]]
name = "room"
origin = [4, 4, 2.5]
target = [1, 1, 0.5]
fov = 50
""" + LIGHTS

PANES = """
[[pane]]
name = "glass"
polygon = [[2.2, 0.4, 0.2], [2.2, 2.4, 0.2], [2.5, 2.4, 1.6], [2.5, 0.4, 1.6]]
thickness = 0.01
extinction = [20, 60, 120]
albedo = 0.1
"""

FURNACE = """
mode = "thermal"
[solve]
tolerance = 0.01
patch_rule = "voxels"
[[surface]]
name = "furnace"
room = { min = [0, 0, 0], max = [2, 2, 4] }
emissivity = 0.8
faces.z0 = { emissivity = 0.85, temperature = 1200 }
faces.z1 = { emissivity = 0.7, temperature = 400 }
faces.x0 = { heat_flux = 500 }
faces.x1 = { temperature = 900 }
faces.y0 = { temperature = 900 }
faces.y1 = { heat_flux = 0 }
[medium]
min = [0, 0, 0]
max = [2, 2, 4]
cells = [4, 4, 7]
extinction = 0.5
heat_source = 5000
"""

SLAB = """
mode = "thermal"
[boundary]
x = "periodic"
y = "periodic"
[solve]
tolerance = 1e-3
patch_rule = "voxels"
[[surface]]
name = "wall"
room = { min = [0, 0, 0], max = [1, 1, 1] }
omit = ["x0", "x1", "y0", "y1"]
emissivity = 1
faces.z0 = { temperature = 1000 }
faces.z1 = { temperature = 500 }
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [2, 2, 5]
extinction = 1.5
heat_source = 0
"""

MESH = """
[solve]
tolerance = 0.05
patch_size = 0.7
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [3, 3, 2.5] }
reflectance = 0.6
[[surface]]
name = "lamp"
rectangle = { origin = [1, 1, 2.4], edge1 = [0, 0.6, 0], edge2 = [0.6, 0, 0] }
emission = 100
[[surface]]
name = "pyramid"
mesh = { file = "pyramid.obj" }
reflectance = [0.2, 0.5, 0.7]
[[light]]
kind = "emitter"
name = "lamp"
surface = "lamp"
[medium]
min = [0, 0, 0]
max = [3, 3, 2.5]
cells = [4, 4, 4]
[[medium.region]]
density = { file = "density.npy", min = [0, 0, 0], max = [3, 3, 2.5], scale = 0.8 }
albedo = 0.7
[[camera]]
name = "room"
origin = [2.7, 2.8, 1.6]
target = [1, 1, 0.8]
fov = 65
"""

PYRAMID = """v 1 1 0.1
v 2 1.1 0.1
v 1.9 2 0.1
v 1 1.9 0.1
v 1.5 1.5 1
f 4 3 2 1
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
"""

PICTURE = ["render {run} --size 80x60 -o picture.png", "render {run} --size 80x60 -o picture.exr"]
EXPORTS = ["export {run} -o surfaces.vtu", "export {run} -o light.glb --finest 0.3", "export {run} -o table.csv"]
VOLUME = ["export {run} -o medium.vti"]
NUMBERS = ["render {run} --show radiosity --size 80x60 -o numbers.exr"]
HEAT = ["render {run} --show temperature --size 80x60 -o heat.png", "export {run} -o surfaces.vtu", "export {run} -o table.csv"]


GAS = """
mode = "thermal"
[[surface]]
name = "furnace"
room = { min = [0, 0, 0], max = [2, 2, 4] }
emissivity = 0.8
heat_flux = 0
faces.z0 = { temperature = 1200 }
faces.z1 = { emissivity = 0.7, temperature = 400 }
[medium]
min = [0, 0, 0]
max = [2, 2, 4]
cells = [3, 3, 5]
gas = { model = "wsgg-bordbar-2020", h2o = 0.2, co2 = 0.1 }
heat_source = 5000
[solve]
"""


def banded(count):
    """A room with a lamp, a sun and a mesh, in `count` bands of its own."""

    def values(low, high):
        return "[" + ", ".join(f"{low + (high - low) * (7 * k % count) / count:.3f}" for k in range(count)) + "]"

    return f"""
bands = {count}
[solve]
patch_rule = "voxels"
[[surface]]
name = "room"
room = {{ min = [0, 0, 0], max = [3, 3, 2] }}
omit = ["z1"]
reflectance = {values(0.1, 0.7)}
[[surface]]
name = "pyramid"
mesh = {{ file = "pyramid.obj" }}
reflectance = {values(0.6, 0.2)}
[[surface]]
name = "lamp"
rectangle = {{ origin = [1.2, 1.2, 1.9], edge1 = [0, 0.5, 0], edge2 = [0.5, 0, 0] }}
emission = {values(5, 40)}
reflectance = 0.3
[[light]]
kind = "emitter"
name = "lamp"
surface = "lamp"
[[light]]
kind = "sun"
name = "sun"
direction = [0.2, 0.3, -1]
irradiance = {values(100, 300)}
[medium]
min = [0, 0, 0]
max = [3, 3, 2]
cells = [4, 4, 4]
[[medium.region]]
density = {{ file = "density.npy", min = [0, 0, 0], max = [3, 3, 2], scale = {values(0.2, 0.8)} }}
albedo = {values(0.9, 0.4)}
"""


def scene(text, **settings):
    """The scene with settings of [solve] added or replaced."""
    for key, value in settings.items():
        line = f"{key} = {value}"
        if re.search(rf"^{key} = ", text, re.M):
            text = re.sub(rf"^{key} = .*$", line, text, count=1, flags=re.M)
        else:
            text = text.replace("[solve]\n", f"[solve]\n{line}\n", 1)
    return text


CASES = {
    "box, dense": (scene(BOX, engine='"dense"'), PICTURE + EXPORTS + VOLUME + NUMBERS),
    "box, spectral": (scene(BOX, engine='"spectral"'), PICTURE),
    "box, rays": (scene(BOX, engine='"rays"', tolerance=0.1), PICTURE + VOLUME),
    "box, links": (scene(BOX, engine='"rays"', tolerance=0.02), []),
    "box, slopes": (scene(BOX, engine='"spectral"', zone_basis='"linear"'), PICTURE),
    "box, three orders": (scene(BOX, engine='"dense"', scattering_orders=3), ["export {run} -o table.csv"]),
    "box, size of zones": (scene(BOX, engine='"dense"', discretization_error="true"), ["export {run} -o table.csv"]),
    "box, paper's series": (BOX, [], "--factors series"),
    "open, dense": (scene(OPEN, engine='"dense"'), PICTURE + EXPORTS + ["relight {run} sun=0.3 sky=2 -o relit.npz"]),
    "open, rays": (scene(OPEN, engine='"rays"'), PICTURE),
    "panes": (scene(OPEN + PANES, engine='"dense"'), PICTURE + EXPORTS),
    "panes, rays": (scene(OPEN + PANES, engine='"rays"'), []),
    "mesh and lamp": (scene(MESH, engine='"dense"'), PICTURE + EXPORTS + VOLUME),
    "mesh and lamp, rays": (scene(MESH, engine='"rays"'), PICTURE),
    "furnace, dense": (scene(FURNACE, engine='"dense"', discretization_error="true"), HEAT + VOLUME),
    "furnace, spectral": (scene(FURNACE, engine='"spectral"'), HEAT),
    "furnace, rays": (scene(FURNACE, engine='"rays"', tolerance=0.05), HEAT),
    "slab, dense": (scene(SLAB, engine='"dense"'), []),
    "slab, spectral": (scene(SLAB, engine='"spectral"'), []),
    "factors kept": (scene(OPEN, engine='"dense"'), ["relight {run} --reflectance floor=0.9 -o relit.npz"], "--keep-factors"),
    "five bands of a gas": (scene(GAS, engine='"dense"', discretization_error="true"), HEAT[1:]),
    "six bands": (scene(banded(6), engine='"dense"'), ["export {run} -o surfaces.vtu", "export {run} -o table.csv"] + VOLUME),
    "25 bands": (scene(banded(25), engine='"dense"'), ["export {run} -o table.csv"]),
    "128 bands": (scene(banded(128), engine='"rays"', tolerance=0.1), []),
    "exchange areas": (scene(BOX, tolerance=0.1), None),
    "exchange areas, panes": (scene(OPEN + PANES), None),
}


def arrays(data):
    """Numeric arrays of an .npz: name to bytes, kind and shape."""
    out = {}
    with zipfile.ZipFile(io.BytesIO(data)) as z:
        for name in z.namelist():
            if name.endswith(".npy") and "header.json" not in name:
                a = np.load(io.BytesIO(z.read(name)), allow_pickle=False)
                out[name] = (a.dtype.str, a.shape, a.tobytes())
    return out


def png(data):
    """Pixels of an 8-bit .png without interlace."""
    at, packed, head = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", body)
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    width, height, depth, colour = head[:4]
    step = {0: 1, 2: 3, 4: 2, 6: 4}[colour] * depth // 8
    raw, line, rows = zlib.decompress(packed), width * step, []
    before = np.zeros(line + step, np.int64)
    for y in range(height):
        kind, row = raw[y * (line + 1)], np.frombuffer(raw, np.uint8, line, y * (line + 1) + 1)
        now = np.zeros(line + step, np.int64)
        for x in range(line):
            a, b, c = now[x], before[x + step], before[x]
            p = a + b - c
            far = [abs(p - a), abs(p - b), abs(p - c)]
            guess = [0, a, b, (a + b) // 2, (a, b, c)[far.index(min(far))]][kind]
            now[x + step] = (int(row[x]) + guess) & 255
        rows.append(now[step:].astype(np.uint8).tobytes())
        before = now
    return {"size": (width, height), "pixels": b"".join(rows)}


def exr(data):
    """Channels of an .exr of scan lines or tiles, uncompressed or by zip: name to values of all pixels. Of other compressions the packed blocks."""
    at, flags = 8, struct.unpack("<I", data[4:8])[0]

    def text(at):
        end = data.index(b"\0", at)
        return data[at:end].decode(), end + 1

    head = {}
    while data[at]:
        name, at = text(at)
        _, at = text(at)
        size = struct.unpack("<I", data[at : at + 4])[0]
        head[name], at = data[at + 4 : at + 4 + size], at + 4 + size
    at += 1
    channels, k = [], 0
    while head["channels"][k]:
        end = head["channels"].index(b"\0", k)
        channels.append((head["channels"][k:end].decode(), struct.unpack("<I", head["channels"][end + 1 : end + 5])[0]))
        k = end + 17
    x0, y0, x1, y1 = struct.unpack("<4i", head["dataWindow"])
    width, height, packing, tiled = x1 - x0 + 1, y1 - y0 + 1, head["compression"][0], bool(flags & 0x200)
    if packing not in (0, 2, 3):
        return {"window": head["dataWindow"], "channels": head["channels"], "blocks": data[at:]}
    kinds = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
    out = {name: np.zeros((height, width), kinds[kind]) for name, kind in channels}
    if tiled:
        tx, ty = struct.unpack("<II", head["tiles"][:8])
        count = -(-width // tx) * -(-height // ty)
    else:
        count = -(-height // {0: 1, 2: 1, 3: 16}[packing])
    for offset in struct.unpack(f"<{count}Q", data[at : at + 8 * count]):
        if tiled:
            i, j, _, _, size = struct.unpack("<4iI", data[offset : offset + 20])
            body, left, top = data[offset + 20 : offset + 20 + size], i * tx, j * ty
            w, h = min(tx, width - left), min(ty, height - top)
        else:
            y, size = struct.unpack("<iI", data[offset : offset + 8])
            body, left, top, w = data[offset + 8 : offset + 8 + size], 0, y - y0, width
            h = min({0: 1, 2: 1, 3: 16}[packing], height - top)
        full = w * h * sum(kinds[kind].itemsize for _, kind in channels)
        if packing and size < full:
            b = np.frombuffer(zlib.decompress(body), np.uint8).astype(np.int64)
            b[1:] -= 128
            b = (np.cumsum(b) & 255).astype(np.uint8)
            half = (len(b) + 1) // 2
            both = np.empty(len(b), np.uint8)
            both[0::2], both[1::2] = b[:half], b[half:]
            body = both.tobytes()
        k = 0
        for row in range(h):
            for name, kind in channels:
                values = np.frombuffer(body, kinds[kind], w, k)
                out[name][top + row, left : left + w] = values
                k += values.nbytes
    return {name: (values.shape, values.tobytes()) for name, values in out.items()}


def glb(data):
    """The binary chunk of a .glb."""
    at, out = 12, {}
    while at < len(data):
        size, kind = struct.unpack("<I4s", data[at : at + 8])
        if kind == b"BIN\0":
            out["buffer"] = data[at + 8 : at + 8 + size]
        at += 8 + size
    return out


def vtk(data):
    """Arrays of a .vtu or .vti of raw appended data: name to kind, shape and bytes."""
    kinds = {"Float64": "<f8", "Float32": "<f4", "Int32": "<i4", "UInt32": "<u4", "Int64": "<i8", "UInt64": "<u8", "UInt8": "<u1"}
    start = data.index(b'encoding="raw">')
    start = data.index(b"_", start) + 1
    length = "<Q" if b'header_type="UInt64"' in data[:start] else "<I"
    out = {}
    for tag in re.findall(rb"<DataArray[^>]*>", data[:start]):
        keys = {k.decode(): v.decode() for k, v in re.findall(rb'(\w+)="([^"]*)"', tag)}
        at = start + int(keys["offset"])
        size = struct.unpack_from(length, data, at)[0]
        at += struct.calcsize(length)
        shape = (-1, int(keys.get("NumberOfComponents", 1)))
        a = np.frombuffer(data[at : at + size], kinds[keys["type"]]).reshape(shape)
        out[f"{keys['Name']} at {len(out)}"] = (a.dtype.str, a.shape, a.tobytes())
    return out


def csv(data):
    """The numbers of a .csv, by row."""
    number = re.compile(rb"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)")
    return {f"row {k}": number.findall(line) for k, line in enumerate(data.splitlines()[1:])}


READERS = {".npz": arrays, ".png": png, ".exr": exr, ".glb": glb, ".vtu": vtk, ".vti": vtk, ".csv": csv}


def run(binary, arguments, folder):
    done = subprocess.run([binary, *arguments.split(), "-q"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments}: exit code {done.returncode}: {done.stderr.strip()}")


def write(binary, case, folder):
    """Everything that a case writes."""
    folder.mkdir(parents=True)
    (folder / "scene.toml").write_text(case[0])
    (folder / "pyramid.obj").write_text(PYRAMID)
    np.save(folder / "density.npy", (1 + np.arange(64) % 7).reshape(4, 4, 4) / 7)
    if case[1] is None:
        return run(binary, "exchange scene.toml -o areas.npz", folder)
    extra = case[2] if len(case) > 2 else ""
    run(binary, f"solve scene.toml -o run.npz {extra}", folder)
    for arguments in case[1]:
        run(binary, arguments.format(run="run.npz"), folder)


def in_one_band(part, other):
    """The first of three equal columns, where the other file has one: grey scenes once had three equal bands."""
    if not (isinstance(part, tuple) and isinstance(other, tuple) and len(part) == 3 and part[0] == other[0] and part[1]):
        return part
    if part[1][-1:] != (3,) or other[1] != part[1][:-1] + (1,):
        return part
    a = np.frombuffer(part[2], part[0]).reshape(part[1])
    same = (a[..., :1] == a) | np.isnan(a[..., :1]) & np.isnan(a)
    return (part[0], other[1], np.ascontiguousarray(a[..., :1]).tobytes()) if same.all() else part


def differences(old, new):
    """What differs between two folders: files, and parts of files. The number of parts that were compared."""
    out, parts = [], 0
    names = {p.name for folder in (old, new) for p in folder.iterdir() if p.suffix in READERS and p.name != "density.npy"}
    for name in sorted(names):
        if not ((old / name).exists() and (new / name).exists()):
            out.append(f"{name}: written by one of them alone")
            continue
        a, b = (READERS[Path(name).suffix]((folder / name).read_bytes()) for folder in (old, new))
        for key in sorted(a.keys() | b.keys()):
            parts += 1
            if in_one_band(a.get(key), b.get(key)) != b.get(key):
                out.append(f"{name}: {key} differs")
    return out, parts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--keep", type=Path, help="a folder for what both write")
    parser.add_argument("--only", help="the cases whose name contains this")
    parser.add_argument("--former", action="append", default=[], metavar="WORD=FORMER", help="a word of the scenes that the old build spells otherwise")
    options = parser.parse_args()
    root = options.keep or Path(tempfile.mkdtemp(prefix="zonal-compare-"))
    failed = total = 0
    for name, case in CASES.items():
        if options.only and options.only not in name:
            continue
        folders = [root / re.sub(r"\W+", "-", name) / side for side in ("old", "new")]
        former = case
        for change in options.former:
            now, before = change.split("=", 1)
            former = (former[0].replace(now, before), *former[1:])
        try:
            write(options.old.resolve(), former, folders[0])
            write(options.new.resolve(), case, folders[1])
            found, parts = differences(*folders)
        except RuntimeError as e:
            found, parts = [str(e)], 0
        total += parts
        failed += bool(found)
        print(f"{name}: {'; '.join(found[:5]) if found else f'{parts} parts identical'}", flush=True)
    print(f"{len(CASES) if not options.only else 'chosen'} cases, {total} parts compared, {failed} cases differ")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
