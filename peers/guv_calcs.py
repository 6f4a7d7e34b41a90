#!/usr/bin/env python3
"""A room with germicidal lamps by guv-calcs and by zonal, in one run: fluence rate, irradiance, time and difference.

    pip install guv-calcs numpy
    cargo build --release
    python peers/guv_calcs.py [--zonal target/release/zonal] [--cell 0.25] [--reflectance 0.5] [--keep DIR]

The room has 6 m × 4 m × 3 m and four lamps of guv-calcs, two of which are tilted. Their photometric files come with the package (MIT licence) and are
written beside the scene for zonal, with the scale and the intensities that guv-calcs uses. Both programs give the fluence rate in cells of the volume and the irradiance on
squares of the floor, in µW/cm²:

* zonal gives means over cells and squares;
* guv-calcs gives values at points. "centres" takes one point in the middle of each cell, as its volumes do; "means" averages its direct light over 5 × 5 × 5 points of
  each cell (5 × 5 on the floor), and takes its reflected light, which is smooth, at the middle.

guv-calcs takes a lamp for a point, or within ten times its largest edge for a row of points if it is longer than wide; zonal takes it for a point. Cells nearer to a lamp than
0.75 m are a row of their own. With reflectance guv-calcs runs twice: with its defaults, 10 × 10 points a wall and passes until the mean changes by less than 2 %, and with points every 25 cm and 0.01 %.
Differences of single values are over the value of zonal, or over 5 % of the mean in darker cells.

Two means are known: that of the direct fluence rate is ∫ I(ω) ℓ(ω) dω over the volume, with the distance ℓ from a lamp to the wall, and the mean irradiance of all walls with reflections is Φ/(A (1 − ρ)), with the power Φ of the lamps, the area A and the reflectance ρ of the walls.
Times are those of the processor: guv-calcs inside the process after a first run, at cell centres; zonal as a whole process.
"""

import importlib.metadata
import json
import os
import pathlib
import subprocess
import tempfile

import numpy as np

from shared import cost, head, parser, row, seconds_of

ROOM = np.array([6.0, 4.0, 3.0])
# Lamp of guv-calcs, position, point that it looks at.
LAMPS = [
    ("ushio_b1", (1.5, 1.2, 2.9), (1.5, 1.2, 0.0)),
    ("aerolamp", (5.7, 3.7, 2.6), (3.0, 2.0, 0.5)),
    ("nukit_lantern", (3.1, 2.2, 2.9), (3.1, 2.2, 0.0)),
    ("uvpro222_b1", (0.3, 3.7, 2.6), (2.5, 1.5, 1.0)),
]
# Points along an edge of a cell for its mean; metres from a lamp that are near.
POINTS = 5
NEAR = 0.75
# Tolerance of zonal; share of the mean below which differences are over this share of the mean, not over the value.
TOLERANCE = 0.003
DARK = 0.05
# µW/cm² of a W/m².
UNIT = 100.0


def lamps():
    """The lamps of guv-calcs."""
    from guv_calcs import Lamp

    out = []
    for key, position, target in LAMPS:
        lamp = Lamp.from_keyword(key)
        lamp.move(*position)
        lamp.aim(*target)
        out.append(lamp)
    return out


def room(reflectance, cells, points=1, **settings):
    """A room of guv-calcs with one volume and the floor, `points` points along an edge of each cell."""
    from guv_calcs import CalcPlane, CalcVol, Room
    from guv_calcs.geometry import Polygon2D, SurfaceGrid, VolumeGrid

    x, y, z = ROOM
    out = Room(x=x, y=y, z=z, units="meters", **settings)
    for lamp in lamps():
        out.add_lamp(lamp)
    outline, count = Polygon2D.rectangle(x, y), tuple(int(points * n) for n in cells)
    volume = VolumeGrid(polygon=outline, depth=z, num_points_init=count, offset=True)
    floor = SurfaceGrid(polygon=outline, num_points_init=count[:2], offset=True)
    out.add_calc_zone(CalcVol(zone_id="volume", geometry=volume))
    out.add_calc_zone(CalcPlane(zone_id="plane", geometry=floor, horiz=True, use_normal=True, fov_vert=180))
    out.set_reflectance(reflectance)
    return out


def calculated(of):
    """Direct and reflected light of a room of guv-calcs on [volume, floor], µW/cm², and seconds."""
    _, seconds = seconds_of(lambda: of.calculate(hard=True))
    zones = [of.calc_zones[name] for name in ("volume", "plane")]
    direct = [np.ma.filled(z.base_values, np.nan).astype(float) for z in zones]
    reflected = [0.0 if z.reflected_values is None else np.asarray(z.reflected_values, float) for z in zones]
    return direct, reflected, seconds


def wall_mean(of):
    """Mean irradiance of the walls of a room of guv-calcs, µW/cm²."""
    planes = [s.plane for s in of.surfaces.values()]
    area = [p.x_spacing * p.y_spacing * p.values.size for p in planes]
    return np.average([np.ma.filled(p.values, np.nan).mean() for p in planes], weights=area)


def means(values, points):
    """Means over blocks of `points` points along each axis, non-finite values left out."""
    shape = [k for n in values.shape for k in (n // points, points)]
    return np.nanmean(values.reshape(shape), axis=tuple(range(1, len(shape), 2)))


def scene(folder, reflectance, cell):
    """Writes the scene of zonal and its photometric files."""
    x, y, z = ROOM
    text = [
        f'name = "germicidal-{reflectance}"\n[solve]\npatch_size = {cell}\ntolerance = {TOLERANCE}\n\n[[surface]]\nname = "room"\n'
        f"room = {{ min = [0, 0, 0], max = [{x}, {y}, {z}] }}\nreflectance = {reflectance}\n\n"
        f"[medium]\nmin = [0, 0, 0]\nmax = [{x}, {y}, {z}]\ncell_size = {cell}\nextinction = 0\n"
    ]
    for number, lamp in enumerate(lamps()):
        name = f"lamp{number}.ies"
        (folder / name).write_bytes(lamp.save_ies())
        position, target = np.array(lamp.position, float), np.array(lamp.aim_point, float)
        # The file is in mW/sr, so that its 1000 "lumens" are a watt; guv-calcs turns the frame of a tilted lamp about the vertical first, zonal by the smallest rotation.
        assert str(lamp.intensity_units) == "mW/sr"
        text.append(
            f'\n[[light]]\nkind = "luminaire"\nname = "{LAMPS[number][0]}"\nfile = "{name}"\nefficacy = 1000\n'
            f"position = {position.tolist()}\ndirection = {(target - position).tolist()}\nrotation = {float(lamp.pose.heading)}\n"
        )
    path = folder / f"room-{reflectance}.toml"
    path.write_text("".join(text))
    return path


def by_zonal(program, path, cells):
    """Fluence rate [x, y, z] and irradiance of the floor [x, y] with their stated errors, µW/cm²; mean irradiance of the walls, seconds, and the engine."""
    solution = path.with_suffix(".npz")
    seconds, _ = cost([program, "solve", path, "-o", solution, "--quiet"])
    z = np.load(solution)
    header = json.loads(bytes(z["header.json"]))
    light = UNIT * (z["incident"] + z["direct"])[:, 0]
    error = UNIT * (z["error"] + z["direct_error"])[:, 0]
    patches = len(z["patch_origin"])
    centre = z["patch_origin"] + 0.5 * (z["patch_e1"] + z["patch_e2"])
    floor = np.nonzero(np.isclose(centre[:, 2], 0.0))[0]
    out = [np.zeros((2, *cells)), np.zeros((2, *cells[:2]))]
    at = lambda p: tuple(np.floor(p / ROOM[: p.shape[1]] * cells[: p.shape[1]]).astype(int).T)
    voxels = np.arange(patches, patches + np.prod(cells))
    for k, values in enumerate((light, error)):
        out[0][(k, *at(z["voxel_centre"]))] = values[voxels]
        out[1][(k, *at(centre[floor][:, :2]))] = values[floor]
    walls = np.average(light[:patches], weights=np.broadcast_to(z["patch_area"].ravel(), patches))
    return out, walls, (seconds, header["report"]["engine"])


def exact_mean_fluence_rate(steps=1440):
    """Mean direct fluence rate of the black room, µW/cm²: ∫ I(ω) ℓ(ω) dω over the volume with the distance ℓ from the lamp to the wall."""
    theta, phi = (np.arange(steps) + 0.5) * np.pi / steps, (np.arange(steps) + 0.5) * 2 * np.pi / steps
    t, p = (x.ravel() for x in np.meshgrid(theta, phi, indexing="ij"))
    frame = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), -np.cos(t)], -1)
    total = 0.0
    for lamp in lamps():
        position = np.array(lamp.position, float)
        towards = lamp.transform_to_world(frame).T - position
        with np.errstate(divide="ignore", invalid="ignore"):
            walls = np.where(towards > 0, (ROOM - position) / towards, -position / towards)
        chord = np.where(towards == 0, np.inf, walls).min(axis=1)
        intensity = lamp.ies.photometry.interpolated().get_intensity(np.degrees(t), np.degrees(p))
        total += (intensity * chord * np.sin(t)).sum() * 2 * (np.pi / steps) ** 2
    return UNIT * 1e-3 * total / np.prod(ROOM)


def difference(title, ours, theirs):
    """A row of the table: means, and differences of single values over those of zonal in per cent."""
    off = 100 * np.abs(theirs - ours) / np.maximum(ours, DARK * ours.mean())
    rms = 100 * np.sqrt(((theirs - ours) ** 2).mean() / (ours**2).mean())
    means = (f"{ours.mean():.3f}", f"{theirs.mean():.3f}", f"{100 * (theirs.mean() / ours.mean() - 1):+.2f}")
    row(title, *means, f"{rms:.2f}", f"{np.median(off):.2f}", f"{np.percentile(off, 99):.2f}", f"{off.max():.1f}")


def compare(ours, theirs, near, label):
    """Rows of the volume away from lamps and near to them, and of the floor."""
    difference(f"{label}: fluence rate, {NEAR} m and more from lamps", ours[0][0][~near], theirs[0][~near])
    difference(f"{label}: fluence rate, nearer", ours[0][0][near], theirs[0][near])
    difference(f"{label}: irradiance of the floor", ours[1][0], theirs[1])


def main():
    p = parser(__doc__)
    p.add_argument("--cell", type=float, default=0.25)
    p.add_argument("--reflectance", type=float, default=0.5)
    p.add_argument("--keep", type=pathlib.Path)
    args = p.parse_args()
    cells = tuple(int(n) for n in np.rint(ROOM / args.cell))
    grid = np.stack(np.meshgrid(*[(np.arange(n) + 0.5) * args.cell for n in cells], indexing="ij"), -1)
    near = np.min([np.linalg.norm(grid - np.array(p), axis=-1) for _, p, _ in LAMPS], axis=0) < NEAR
    version = subprocess.run([args.zonal, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    print(f"{version}, guv-calcs {importlib.metadata.version('guv-calcs')}, {os.cpu_count()} threads, {np.prod(cells)} cells\n")
    with tempfile.TemporaryDirectory() as folder:
        folder = args.keep or pathlib.Path(folder)
        folder.mkdir(exist_ok=True)
        black, _, direct_time = by_zonal(args.zonal, scene(folder, 0.0, args.cell), cells)
        bright, walls, full_time = by_zonal(args.zonal, scene(folder, args.reflectance, args.cell), cells)
    calculated(room(0.0, cells))
    direct, _, fast = calculated(room(0.0, cells))
    fine = [means(v, POINTS) for v in calculated(room(0.0, cells, POINTS))[0]]
    default = room(args.reflectance, cells)
    _, coarse, usual = calculated(default)
    finest = room(args.reflectance, cells, reflectance_threshold=1e-4)
    finest.set_reflectance_spacing(args.cell, args.cell)
    _, converged, slow = calculated(finest)
    head("", "zonal, mean", "guv-calcs, mean", "%", "root mean square of differences, %", "median, %", "99 of 100, %", "worst, %")
    compare(black, direct, near, "direct light, centres")
    compare(black, fine, near, "direct light, means")
    for title, reflected in (("defaults", coarse), ("converged", converged)):
        compare(bright, [d + r for d, r in zip(fine, reflected)], near, f"reflectance {args.reflectance}, {title}")
    area = 2 * (ROOM[0] * ROOM[1] + ROOM[1] * ROOM[2] + ROOM[2] * ROOM[0])
    exact = UNIT * 1e-3 * sum(lamp.get_total_power() for lamp in lamps()) / (area * (1 - args.reflectance))
    print()
    head("", "zonal", "guv-calcs, defaults", "guv-calcs, converged")
    both = f"{direct[0].mean():.4f} (centres), {fine[0].mean():.4f} (means)"
    row(f"mean fluence rate of direct light, exact {exact_mean_fluence_rate():.4f}", f"{black[0][0].mean():.4f}", both, "")
    row(f"mean irradiance of the walls, exact {exact:.4f}", *(f"{x:.4f}" for x in (walls, wall_mean(default), wall_mean(finest))))
    row("direct light alone, processor seconds", f"{direct_time[0]:.2f} ({direct_time[1]})", f"{fast:.2f}", "")
    row("with reflections, processor seconds", f"{full_time[0]:.2f} ({full_time[1]})", f"{usual:.2f}", f"{slow:.1f}")
    stated = lambda solved: 100 * np.sqrt((solved[0][1] ** 2).mean() / (solved[0][0] ** 2).mean())
    print(f"\nstated error of zonal's fluence rate, root mean square: {stated(black):.2f} % and {stated(bright):.2f} %")


if __name__ == "__main__":
    main()
