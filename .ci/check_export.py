"""Reads what `zonal export` wrote with VTK's own readers and compares with the solution: check_export.py RUN.npz NAME.vtu NAME.vti NAME.medium.npz VOLUME.npz."""

# Guards (files): sums over the cells of .vtu and .vti equal the sums of the solution, read by VTK (run by CI).

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

run, surfaces, volume, medium, harmonics = sys.argv[1:]
z = np.load(run)
header = json.loads(bytes(z["header.json"]))
patches, voxels, panes = len(z["patch_area"]), len(z["voxel_cell"]), len(z["pane_zone_area"])
P, V, S = slice(0, patches), slice(patches, patches + voxels), slice(patches + voxels, None)


def read(path, reader):
    """The cells' arrays and the field data's names."""
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(path))
    reader.SetFileName(path)
    reader.Update()
    assert not errors, f"{path}: VTK could not read it"
    grid = reader.GetOutput()
    cells, names = grid.GetCellData(), grid.GetFieldData()
    arrays = {}
    for i in range(cells.GetNumberOfArrays()):
        a = cells.GetArray(i)
        assert a is not None, f"{path}: array {i} is none of numbers"
        values = vtk_to_numpy(a)
        assert len(values) == grid.GetNumberOfCells() and np.isfinite(values).all(), (path, a.GetName())
        if values.ndim == 2:
            assert [a.GetComponentName(k) for k in range(3)] == ["red", "green", "blue"], a.GetName()
        arrays[a.GetName()] = values
    lists = {}
    for i in range(names.GetNumberOfArrays()):
        a = names.GetAbstractArray(i)
        lists[a.GetName()] = [a.GetValue(k) for k in range(a.GetNumberOfValues())]
    return grid, arrays, lists


def same(what, found, wanted, within=1e-12):
    scale = np.abs(wanted).max()
    worst = np.abs(np.asarray(found) - wanted).max()
    assert worst <= within * max(scale, 1e-300), f"{what}: {found} is not {wanted}"


# Patches and panes.
grid, a, names = read(surfaces, vtk.vtkXMLUnstructuredGridReader())
assert grid.GetNumberOfCells() == patches + panes
row = a["zone"]
kind = a["kind"]
same("areas", a["area [m2]"], np.r_[z["patch_area"], z["pane_zone_area"]])
for name, key in (("radiosity", "radiosity"), ("direct", "direct"), ("error", "error")):
    same(name, a[f"{name} [W/m2]"], z[key][row])
same("incident", a["irradiance [W/m2]"] + a["fluence [W/m2]"], z["incident"][row])
area, rho = a["area [m2]"][:, None], a["reflectance"]
same("power that leaves", (a["radiosity [W/m2]"] * area)[kind == 0].sum(0), (z["radiosity"][P] * z["patch_area"][:, None]).sum(0))
absorbed = ((1 - rho) * (a["irradiance [W/m2]"] + a["direct [W/m2]"]) * area)[kind == 0].sum(0)
energy = header["report"]["energy"]
reported = sum(np.array(x["power"]) for x in energy["absorbed_surfaces"])
same("absorbed by surfaces", absorbed, reported, 1e-9)
pane_volume = area * a["thickness [m]"][:, None]
taken = (a["extinction [1/m]"] * (1 - a["albedo"]) * (a["fluence [W/m2]"] + a["direct [W/m2]"]) * pane_volume).sum(0)
same("absorbed by panes", taken, energy["absorbed_panes"], 1e-9)
assert len(names["surface names"]) > a["surface"].max() and a["surface"].min() >= -1
groups = names.get("group names", [])
if len(groups) > 1:
    same("groups of surfaces", sum(a[f"radiosity of {g} [W/m2]"] for g in groups), a["radiosity [W/m2]"], 1e-6)

# Point data of the .vtu, each cell with points of its own: finite, near the values of the cells, and of the right power.
points = grid.GetPointData()
corner = {points.GetArrayName(i): vtk_to_numpy(points.GetArray(i)) for i in range(points.GetNumberOfArrays())}
assert set(corner) == {"radiosity [W/m2]", "total irradiance [W/m2]"}, set(corner)
ends = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
for name, cells in (("radiosity [W/m2]", a["radiosity [W/m2]"]), ("total irradiance [W/m2]", a["irradiance [W/m2]"] + a["direct [W/m2]"])):
    values = corner[name]
    assert values.shape == (grid.GetNumberOfPoints(), 3) and np.isfinite(values).all()
    means = np.add.reduceat(values, ends[:-1]) / np.diff(ends)[:, None]
    powers = [(x * area)[kind == 0].sum(0) for x in (means, cells)]
    assert (abs(powers[0] / powers[1] - 1) < 0.25).all(), (name, powers)

# Areas of the cells themselves.
sizes = vtk.vtkCellSizeFilter()
sizes.SetInputData(grid)
sizes.Update()
same("areas of cells", vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Area")), a["area [m2]"], 1e-9)

# The medium.
grid, a, names = read(volume, vtk.vtkXMLImageDataReader())
free = a["volume [m3]"][:, None]
own = np.broadcast_to(z["voxel_volume"], voxels)[:, None]
same("free volume", a["volume [m3]"].sum(), own.sum())
assert a["zones"].sum() == voxels
kappa, omega = z["voxel_extinction"], z["voxel_albedo"]
B, G = z["radiosity"][V], z["incident"][V]
H = G + z["direct"][V]
found = a["extinction [1/m]"]
same("4 Σ κBV", (4 * found * a["radiosity [W/m2]"] * free).sum(0), (4 * kappa * B * own).sum(0))
same("Σ κGV", (found * a["fluence [W/m2]"] * free).sum(0), (kappa * G * own).sum(0))
arrives = a["fluence [W/m2]"] + a["direct [W/m2]"]
same("absorbed by the medium", (found * (1 - a["albedo"]) * arrives * free).sum(0), energy["absorbed_volumes"], 1e-9)
if len(groups) > 1:
    same("groups of the medium", sum(a[f"radiosity of {g} [W/m2]"] for g in groups), a["radiosity [W/m2]"], 1e-6)
# A cell lies where the voxel grid has it: the zone named there has its centre in it.
for i in np.flatnonzero(a["zones"]):
    lo_hi = np.array(grid.GetCell(int(i)).GetBounds()).reshape(3, 2)
    centre = z["voxel_centre"][a["zone"][i] - patches]
    assert (lo_hi[:, 0] - 1e-9 <= centre).all() and (centre <= lo_hi[:, 1] + 1e-9).all(), (i, centre)

# The medium beside the .glb.
m = np.load(medium)
about = json.loads(bytes(m["about"]))
dims = about["dims"]
assert m["radiosity"].shape == (len(about["groups"]), *dims, 3)
order = lambda x: np.moveaxis(x, (0, 1, 2), (2, 1, 0)).reshape(-1, *x.shape[3:])  # x runs fastest in VTK
same("volume of .npz", order(m["volume"]), a["volume [m3]"], 1e-6)
same("radiosity of .npz", order(m["radiosity"].sum(0)), a["radiosity [W/m2]"], 1e-5)
same("fluence of .npz", order(m["fluence"].sum(0)), arrives, 1e-5)

# The irradiance volume: the light of a point has a vector no longer than its fluence, and half of the points beside voxel centres have nearly the fluence of the zone.
h = np.load(harmonics)
about = json.loads(bytes(h["about"]))
c, outside = h["coefficients"], h["outside"].astype(bool)
assert c.shape == (*about["dims"], 4, 3) and outside.sum() == about["points outside"]
G, F = c[..., 0, :] / 0.28209479, np.linalg.norm(c[..., 1:, :], axis=-2) / 0.48860251
assert (F[~outside] <= G[~outside] * (1 + 1e-5)).all() and (G[~outside] > 0).all()
low, high, dims = (np.array(about[k]) for k in ("min", "max", "dims"))
near = tuple((((z["voxel_centre"] - low) / (high - low) * dims).astype(int)).clip(0, dims - 1).T)
ratio = np.median((G[near] / (z["incident"] + z["direct"])[V])[~outside[near]], axis=0)
assert (abs(ratio - 1) < 0.1).all(), ratio

print(f"{surfaces}, {volume}, {medium}, {harmonics}: every array read, sums agree")
