#!/usr/bin/env python3
"""Three views of Mitsuba's Cornell box by Mitsuba 3 and by zonal: processor time of all three to 1 % RMS of blocks of 8 x 8 pixels.

    python cornell.py [--cases vacuum,haze,coloured-haze] [--seconds 60] [--zonal target/release/zonal] [--variant llvm_ad_rgb]

Needs the meshes of ../shared/data/cornell. Mitsuba draws batches of each view, with other seeds, for --seconds of processor time; the spread of the batches gives
the standard error of its blocks, and its time to 1 % is its processor time times (error / 1 %)^2. zonal solves once and draws the same views, whole processes.
The error of ours is that of its blocks against Mitsuba's mean, Mitsuba's noise taken off. Errors are root mean squares over the mean of the picture. Blocks that
see the lamp, and those beside them, are left out.
"""

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from shared import ROOT, cost, head, parser, row, seconds_of  # noqa: E402

TARGET = 0.01

BLOCK = 8
WHITE = [0.885809, 0.698859, 0.666422]
RED = [0.570068, 0.0430135, 0.0443706]
GREEN = [0.105421, 0.37798, 0.076425]
LAMP = [18.387, 13.9873, 6.75357]
WALLS = {"back": WHITE, "ceiling": WHITE, "floor": WHITE, "greenwall": GREEN, "redwall": RED, "smallbox": WHITE, "largebox": WHITE}
VIEWS = {
    "front": ([278, 273, -800], [278, 273, -799], 39.3077),
    "left": ([520, 300, 30], [180, 180, 400], 65),
    "low": ([60, 60, 40], [380, 200, 420], 65),
}
CASES = {"vacuum": None, "haze": (0.002, [0.8] * 3), "coloured-haze": (0.001, [0.95, 0.6, 0.3])}


def theirs_of(mi, meshes, medium, view, o):
    T = mi.ScalarTransform4f
    origin, target, fov = VIEWS[view]
    diffuse = lambda rgb: {"type": "twosided", "b": {"type": "diffuse", "reflectance": {"type": "rgb", "value": rgb}}}
    mesh = lambda name: {"type": "obj", "filename": str(meshes / f"cbox_{name}.obj"), "face_normals": True}
    film = {"type": "hdrfilm", "width": o.size, "height": o.size, "pixel_format": "rgb", "component_format": "float32", "rfilter": {"type": "box"}}
    sensor = {
        "type": "perspective", "fov_axis": "smaller", "fov": fov, "near_clip": 1, "far_clip": 5000,
        "to_world": T().look_at(origin=origin, target=target, up=[0, 1, 0]), "film": film, "sampler": {"type": "multijitter"},
    }
    scene = {"type": "scene", "integrator": {"type": "volpath" if medium else "path", "max_depth": -1, "rr_depth": 5}, "sensor": sensor}
    scene |= {name: mesh(name) | {"bsdf": diffuse(rgb)} for name, rgb in WALLS.items()}
    scene["lamp"] = mesh("luminaire") | {
        "to_world": T().translate([0, -0.5, 0]),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": WHITE}},
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": LAMP}},
    }
    if medium:
        extinction, albedo = medium
        haze = {"type": "homogeneous", "id": "haze", "sigma_t": {"type": "rgb", "value": [extinction] * 3}, "albedo": {"type": "rgb", "value": albedo}, "phase": {"type": "isotropic"}}
        cube = T().translate([278, 274.4, 279.6]).scale([280, 276, 280])
        reference = {"type": "ref", "id": "haze"}
        scene = {"type": "scene", "haze": haze} | scene
        scene["medium"] = {"type": "cube", "to_world": cube, "bsdf": {"type": "null"}, "interior": reference}
        if view != "front":
            sensor["medium"] = reference
    return scene


def ours_of(meshes, medium, case, o):
    text = f'name = "{case}"\n[solve]\ntolerance = {o.tolerance}\npatch_size = {o.patch}\n'
    for name, rgb in (WALLS | {"luminaire": WHITE}).items():
        place = ", translate = [0, -0.5, 0]" if name == "luminaire" else ""
        text += f'[[surface]]\nname = "{name}"\nmesh = {{ file = "{meshes / f"cbox_{name}.obj"}"{place} }}\nreflectance = {rgb}\nsides = "front"\n'
    text += f'emission = {[math.pi * x for x in LAMP]}\n[[light]]\nkind = "emitter"\nsurface = "luminaire"\n'
    for name, (origin, target, fov) in VIEWS.items():
        text += f'[[camera]]\nname = "{name}"\norigin = {origin}\ntarget = {target}\nup = [0, 1, 0]\nfov = {fov}\n'
    if medium:
        n = o.cells
        text += f"[medium]\nmin = [-2, -1.6, -0.4]\nmax = [558, 550.4, 559.6]\ncells = [{n}, {n}, {n}]\nextinction = {medium[0]}\nalbedo = {medium[1]}\n"
    return text


def blocks(image):
    n = image.shape[0] // BLOCK
    return image.reshape(n, BLOCK, n, BLOCK, 3).mean((1, 3))


def mitsuba(mi, meshes, medium, view, o):
    """Blocks of every batch, the mask of blocks without the lamp, and the seconds of all batches."""
    scene = mi.load_dict(theirs_of(mi, meshes, medium, view, o))
    mi.render(scene, spp=4, seed=99_999) + 0
    n = o.size // BLOCK
    means, lit, seconds = [], np.zeros((n, n), bool), 0.0
    while seconds < o.seconds or len(means) < 4:
        image, spent = seconds_of(lambda: np.array(mi.render(scene, spp=o.batch, seed=len(means)), dtype=np.float64)[..., :3])
        seconds += spent
        means.append(blocks(image))
        lit |= image.max(2).reshape(n, BLOCK, n, BLOCK).max((1, 3)) > 0.5 * max(LAMP)
    around = np.pad(lit, 1)
    near = sum(np.roll(around, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1))[1:-1, 1:-1]
    return np.array(means), near == 0, seconds


def relative_rms(squares, value, mask):
    """The root of the mean square of the worst channel over the mean of the picture."""
    return math.sqrt(max(0.0, (squares[mask].mean(0) / value[mask].mean(0) ** 2).max()))


def main():
    p = parser(__doc__)
    p.add_argument("--cases", default=",".join(CASES))
    p.add_argument("--seconds", type=float, default=60.0, help="processor seconds of Mitsuba for each view")
    p.add_argument("--size", type=int, default=256, help="pixels along an edge")
    p.add_argument("--batch", type=int, default=64, help="samples a pixel of a batch")
    p.add_argument("--tolerance", type=float, default=0.03)
    p.add_argument("--patch", type=float, default=40.0, help="greatest patch of ours, mm")
    p.add_argument("--cells", type=int, default=14, help="cells of our haze along an edge")
    p.add_argument("--variant", default="llvm_ad_rgb")
    p.add_argument("--data", default=str(ROOT / "../shared/data"))
    p.add_argument("--out", default="out/mitsuba")
    o = p.parse_args()
    import mitsuba as mi

    mi.set_variant(o.variant)
    out, meshes = Path(o.out), (Path(o.data) / "cornell/mitsuba-cbox/meshes").resolve()
    out.mkdir(parents=True, exist_ok=True)
    print(f"Mitsuba {mi.__version__}, {o.variant}, multijitter, rr_depth 5; processor seconds")
    head("case", "Mitsuba, 1 % in three views", "zonal: solve", "three views", "both", "blocks of zonal off, by view", "times faster")
    for case in o.cases.split(","):
        medium = CASES[case]
        scene, run = out / f"cornell-{case}.toml", str(out / f"cornell-{case}.npz")
        scene.write_text(ours_of(meshes, medium, case, o))
        solve, _ = cost([o.zonal, "solve", str(scene), "-o", run, "--quiet"])
        draw, theirs, errors = 0.0, 0.0, []
        for view in VIEWS:
            picture = str(out / f"cornell-{case}-{view}.exr")
            draw += cost([o.zonal, "render", run, "--camera", view, "--size", f"{o.size}x{o.size}", "-o", picture, "--quiet"])[0]
            batches, mask, seconds = mitsuba(mi, meshes, medium, view, o)
            mean, variance = batches.mean(0), batches.var(0, ddof=1)
            noise = relative_rms(variance / len(batches), mean, mask)
            theirs += seconds * (noise / TARGET) ** 2
            ours = blocks(np.array(mi.Bitmap(picture), dtype=np.float64)[..., :3])
            errors.append(relative_rms((ours - mean) ** 2 - variance / len(batches), mean, mask))
            print(f"  {case}, {view}: Mitsuba {seconds:.0f} s, blocks {100 * noise:.2f} %", file=sys.stderr)
        off = ", ".join(f"{100 * e:.2f} %" for e in errors)
        times = (f"{t:.2f}" for t in (solve, draw, solve + draw))
        row(case, f"{theirs:.0f}", *times, off, f"{theirs / (solve + draw):.0f}")


if __name__ == "__main__":
    main()
