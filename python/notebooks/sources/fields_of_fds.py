# %% [markdown]
# # Fields of FDS
# The package `fdsreader` reads the output of FDS; its arrays become temperature and extinction of a medium, and zonal gives the heat flux on the walls without
# ray effects. Without a fire at hand, this notebook writes a small output in FDS's format: a hot layer of soot below a ceiling.
# %%
import tempfile
from pathlib import Path

import fdsreader
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

folder = Path(tempfile.mkdtemp())
nodes = (9, 9, 7)
extent = ((0.0, 4.0), (0.0, 4.0), (0.0, 3.0))
axes = [np.linspace(a, b, n) for (a, b), n in zip(extent, nodes)]
x, y, z = np.meshgrid(*axes, indexing="ij")
layer = 1 / (1 + np.exp(-(z - 1.8) / 0.2))
temperature = 20 + 600 * layer * np.exp(-((x - 2) ** 2 + (y - 2) ** 2) / 4)          # degrees Celsius
soot = 1.5 * layer                                                                   # extinction, 1/m


def record(data):
    """A record of Fortran's sequential files."""
    size = np.array([len(data)], dtype="<i4").tobytes()
    return size + data + size


def write_slice(path, quantity, short, unit, field):
    """A slice file of FDS with one time."""
    out = b"".join(record(text.encode().ljust(30)) for text in (quantity, short, unit))
    bounds = [v for n in nodes for v in (0, n - 1)]
    out += record(np.array(bounds, dtype="<i4").tobytes())
    out += record(np.array([0.0], dtype="<f4").tobytes()) + record(field.astype("<f4").ravel(order="F").tobytes())
    path.write_bytes(out)


lines = ["TITLE", " layer", "", "CHID", " layer", "", "FDSVERSION", "FDS-6.8.0", "", "GRID mesh1", " ".join(str(n - 1) for n in nodes) + " 0", "", "PDIM",
         " ".join(f"{v}" for e in extent for v in e) + " 0 0 0"]
for name, axis in zip("XYZ", axes):
    lines += ["", f"TRN{name}", "0", *[f"{i} {v:.5f}" for i, v in enumerate(axis)]]
lines += ["", "OBST", "0", "", "VENT", "0 0", "", "CVENT", "0", ""]
bounds = " ".join(f"0 {n - 1}" for n in nodes)
for k, (quantity, short, unit, field) in enumerate((("TEMPERATURE", "temp", "C", temperature), ("EXTINCTION COEFFICIENT", "ext", "1/m", soot)), start=1):
    write_slice(folder / f"layer_{k}.sf", quantity, short, unit, field)
    lines += [f"SLCF 1 # STRUCTURED &  {bounds} ! {k}", f" layer_{k}.sf", f" {quantity}", f" {short}", f" {unit}", ""]
(folder / "layer.smv").write_text("\n".join(lines))
# %%
simulation = fdsreader.Simulation(str(folder / "layer.smv"))
arrays = {}
for field in simulation.slices:
    arrays[field.quantity.name] = np.asarray(field.to_global())[0]      # the first time
    print(field.quantity.name, arrays[field.quantity.name].shape)
# %% [markdown]
# Values at nodes become means of cells. Walls have 300 K.
# %%
def cells(nodal):
    for axis in range(3):
        nodal = 0.5 * (np.take(nodal, range(1, nodal.shape[axis]), axis) + np.take(nodal, range(nodal.shape[axis] - 1), axis))
    return nodal


fire = zn.Scene("layer", mode="thermal")
low, high = [e[0] for e in extent], [e[1] for e in extent]
fire.surface(room=(low, high), name="wall", emissivity=0.9, temperature=300, patch_size=0.5)
fire.medium(low, high, cells=[n - 1 for n in nodes], extinction=cells(arrays["EXTINCTION COEFFICIENT"]), albedo=0.0,
            temperature=cells(arrays["TEMPERATURE"]) + 273.15)
solution = fire.solve(tolerance=0.02)
# %%
floor = solution.zones_of("wall.z0")
centre, flux = solution.centre[floor], -solution.net_flux[floor] / 1e3
fig, ax = plt.subplots(figsize=(5, 4), layout="constrained")
picture = ax.tricontourf(centre[:, 0], centre[:, 1], flux, 12, cmap="inferno")
fig.colorbar(picture, label="heat flux / (kW/m²)")
ax.set(xlabel="x / m", ylabel="y / m", title="Floor below the layer", aspect="equal")
plt.show()
print(f"largest error {solution.net_flux_error[floor].max() / 1e3:.3f} kW/m2")
