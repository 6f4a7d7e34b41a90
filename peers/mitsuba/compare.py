#!/usr/bin/env python3
"""One view of a room of haze by Mitsuba 3 and by zonal: processor time to 1 % RMS of a pixel.

    python compare.py [--spp 512] [--batches 2] [--out out/mitsuba] [--zonal target/release/zonal]
                      [--sampler multijitter] [--rr-depth 5] [--variant llvm_ad_mono] [--runs 5]

Reads c0.toml beside it for both. Mitsuba draws --spp samples a pixel in --batches of other seeds; the spread of these gives the
standard error σ of its picture, and the time to 1 % is its processor time times (σ/0.01)². A folder that holds batches of the
same settings is added to, so that a long run may be had in parts. Ours is solved and drawn by the command, whole processes, the
least of --runs. The error of ours is sqrt(<d²> - <σ²>) over the mean, d the difference to Mitsuba's picture of this very run; 'at
most' adds twice the standard error of <d²> - <σ²>, from its spread over blocks of the picture.
"""

import math
import sys
import tomllib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from shared import ROOT, cost, head, parser, row, seconds_of  # noqa: E402

TARGET = 0.01


def options():
    p = parser(__doc__)
    p.add_argument("--spp", type=int, default=512, help="samples a pixel in all that Mitsuba draws in this run")
    p.add_argument("--batches", type=int, default=2, help="pictures of other seeds that these are divided among")
    p.add_argument("--sampler", default="multijitter", help="independent, stratified, multijitter, ...")
    p.add_argument("--rr-depth", type=int, default=5, help="segments from which on Mitsuba ends paths by lot")
    p.add_argument("--variant", default="llvm_ad_mono", help="llvm_ad_mono, or scalar_rgb where there is no LLVM")
    p.add_argument("--size", type=int, default=256, help="pixels along an edge")
    p.add_argument("--cells", default="10,20,40", help="voxels along an edge of ours")
    p.add_argument("--runs", type=int, default=5, help="solves and pictures of ours, of which the fastest counts")
    p.add_argument("--reference", help="the 64 x 64 picture, an .npz; not compared with where there is none", default=str(ROOT / "../shared/reference/montecarlo/image_c0_K1_a0.90_r0.5_inside_64.npz"))
    p.add_argument("--out", default="out/mitsuba")
    return p.parse_args()


# --- Mitsuba -------------------------------------------------------------------------------------------------------------------


def theirs_of(scene, o):
    """The scene of c0.toml as Mitsuba's dictionary."""
    import mitsuba as mi

    T = mi.ScalarTransform4f
    medium, camera, room = scene["medium"], scene["camera"][0], scene["surface"][0]
    lo, hi = room["room"]["min"], room["room"]["max"]
    haze = {
        "type": "homogeneous",
        "id": "haze",
        "sigma_t": {"type": "rgb", "value": float(medium["extinction"])},
        "albedo": {"type": "rgb", "value": float(medium["albedo"])},
        "phase": {"type": "isotropic"},
    }
    # The camera stands in the haze and must be declared, or its first segment is not attenuated.
    sensor = {
        "type": "perspective",
        "fov_axis": "x",
        "fov": camera["fov"],
        "near_clip": 1e-3,
        "far_clip": 100.0,
        "to_world": T().look_at(origin=camera["origin"], target=camera["target"], up=[0, 0, 1]),
        "medium": {"type": "ref", "id": "haze"},
        "sampler": {"type": o.sampler},
        "film": {
            "type": "hdrfilm",
            "width": o.size,
            "height": o.size,
            "pixel_format": "luminance",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }
    out = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": o.rr_depth},
        "haze": haze,
        "sensor": sensor,
    }
    # A rectangle looks along +z: turned so that it looks inward.
    turns = [([0, 1, 0], 90), ([0, 1, 0], -90), ([1, 0, 0], -90), ([1, 0, 0], 90), ([1, 0, 0], 0), ([1, 0, 0], 180)]
    for k, (axis, angle) in enumerate(turns):
        name = "xyz"[k // 2] + str(k % 2)
        centre = [(a + b) / 2 for a, b in zip(lo, hi)]
        centre[k // 2] = (hi if k % 2 else lo)[k // 2]
        # Of a cube: every wall is as wide as it is high.
        half = (hi[0] - lo[0]) / 2
        wall = {
            "type": "rectangle",
            "to_world": T().translate(centre).rotate(axis, angle).scale([half, half, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": room["reflectance"]}},
        }
        emission = room.get("faces", {}).get(name, {}).get("emission", 0)
        if emission:
            wall["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": emission / math.pi}}
        out["wall-" + name] = wall
    return out


def mitsuba(scene, o, store):
    """Batches of Mitsuba's picture, those of earlier runs included: an array [batch, y, x], and the seconds of each."""
    import mitsuba as mi

    mi.set_variant(o.variant)
    key = f"mitsuba {mi.__version__}, {o.variant}, {o.sampler}, rr_depth {o.rr_depth}, {o.size}, {o.spp // o.batches} a batch"
    images, seconds = [], []
    if store.exists():
        old = np.load(store)
        if str(old["key"]) == key:
            images, seconds = list(old["images"]), list(old["seconds"])
    loaded = mi.load_dict(theirs_of(scene, o))
    # Kernels are compiled by a first picture, which does not count.
    mi.render(loaded, spp=1, seed=10_000) + 0
    for k in range(len(images), len(images) + o.batches):
        image, spent = seconds_of(lambda: np.array(mi.render(loaded, spp=o.spp // o.batches, seed=k), dtype=np.float64))
        images.append(image.reshape(o.size, o.size, -1)[..., 0])
        seconds.append(spent)
        np.savez(store, key=key, images=images, seconds=seconds)
        print(f"  Mitsuba, batch {k}: {seconds[-1]:.1f} s", file=sys.stderr)
    return np.array(images), np.array(seconds), key


# --- zonal ---------------------------------------------------------------------------------------------------------------------


def ours_of(cells, o, out):
    """Solved and drawn: the picture, the seconds of either."""
    text = (HERE / "c0.toml").read_text().replace("cells = [40, 40, 40]", f"cells = [{cells}, {cells}, {cells}]")
    files = [out / f"c0-{cells}{end}" for end in (".toml", ".npz", ".exr")]
    scene, run, picture = map(str, files)
    files[0].write_text(text)
    solve = [o.zonal, "solve", scene, "-o", run, "--quiet"]
    draw = [o.zonal, "render", run, "--size", f"{o.size}x{o.size}", "-o", picture, "--quiet"]
    seconds = [min(cost(c)[0] for _ in range(o.runs)) for c in (solve, draw)]
    return read_exr(picture), seconds


def read_exr(path):
    import mitsuba as mi

    return np.array(mi.Bitmap(path), dtype=np.float64)[..., 0]


# --- beside each other -----------------------------------------------------------------------------------------------------------


def binned(image, n):
    m = image.shape[0] // n
    return image.reshape(n, m, n, m).mean((1, 3))


def error(ours, theirs, se):
    """RMS of the difference over the mean, their noise taken off, and what it is at most."""
    squares = binned((ours - theirs) ** 2 - se**2, 8)
    own = squares.std(ddof=1) / 8
    return [math.sqrt(max(s, 0)) / theirs.mean() for s in (squares.mean(), squares.mean() + 2 * own)]


def percent(errors):
    return "{:.2f} % (at most {:.2f} %)".format(*(100 * e for e in errors))


def side_by_side(ours, theirs, path):
    """Ours, theirs, and about grey ten times the difference of their means over blocks of 4 x 4 pixels."""
    from mitsuba import Bitmap

    top = np.quantile(theirs, 0.995)
    blocks = binned(ours - theirs, theirs.shape[0] // 4)
    off = 0.5 * top + 10 * blocks.repeat(4, 0).repeat(4, 1)
    row = np.clip(np.concatenate([ours, theirs, off], axis=1) / top, 0, 1)
    grey = np.repeat((255 * row ** (1 / 2.2) + 0.5).astype(np.uint8)[..., None], 3, axis=2)
    Bitmap(grey).write(str(path))


def main():
    o = options()
    out = Path(o.out)
    out.mkdir(parents=True, exist_ok=True)
    scene = tomllib.loads((HERE / "c0.toml").read_text())
    images, seconds, key = mitsuba(scene, o, out / "mitsuba.npz")
    theirs = images.mean(0)
    se = images.std(0, ddof=1) / math.sqrt(len(images))
    noise = math.sqrt((se**2).mean()) / theirs.mean()
    spp = o.spp // o.batches * len(images)
    total = seconds.sum()
    print(f"{key}: {spp} samples a pixel, {total:.1f} processor seconds, noise {100 * noise:.2f} % of the mean")
    print(f"  at {100 * TARGET:g} %: {total * (noise / TARGET) ** 2:.0f} processor seconds a view\n")
    reference = np.load(o.reference) if Path(o.reference).is_file() else None
    if reference is not None:
        img, own = reference["img"].astype(float), reference["se"]
        small = binned(theirs, 64)
        sigma = np.sqrt(own**2 + binned(se**2, 64) / (o.size // 64) ** 2)
        print(f"Mitsuba against the table of 64 x 64: {percent(error(small, img, sigma))}\n")
    head("cells", "solve, s", "view, s", "off Mitsuba", "off the table of 64 x 64", "mean")
    for cells in map(int, o.cells.split(",")):
        ours, (solve, draw) = ours_of(cells, o, out)
        table = "-" if reference is None else percent(error(binned(ours, 64), img, own))
        off = percent(error(ours, theirs, se))
        mean = 100 * (ours.mean() / theirs.mean() - 1)
        row(cells, f"{solve:.3f}", f"{draw:.3f}", off, table, f"{mean:+.2f} %")
        side_by_side(ours, theirs, out / f"c0-{cells}.png")


if __name__ == "__main__":
    main()
