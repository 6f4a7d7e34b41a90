# %% [markdown]
# # Smoke from an OpenVDB file
# A density grid becomes the extinction of a medium: each voxel has the exact mean of the file. The file is a sample of the checkout; give the path of another.
# %%
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

checkout = Path(os.environ.get("ZONAL_ROOT", "../.."))
path = checkout / "crates/io/tests/data/mixed.vdb"
low, high, cells = [-5, -5, -5], [150, 75, 45], [16, 8, 5]
scene = zn.Scene("smoke")
scene.surface(rectangle=([-5, -5, -5], [155, 0, 0], [0, 80, 0]), name="ground", reflectance=0.3, patch_size=20)
scene.medium(low, high, cells=cells, extinction=0.0, albedo=0.9)
scene.region(density={"file": str(path), "grid": "density", "scale": 0.05})
scene.sky(1.0)
scene.sun([0.4, 0.3, -1], 5.0)
forecast = scene.check()
print(forecast["voxel_zones"], "voxels")
solution = scene.solve(tolerance=0.05)
print(solution)
# %% [markdown]
# Fluence in the smoke, seen from the side (mean along y) and from above (mean along z):
# %%
fields = solution.medium_arrays()
fluence = (fields["incident"] + fields["direct"]).mean(axis=-1)
fig, axes = plt.subplots(2, 1, figsize=(6, 5), layout="constrained", sharex=True)
for ax, axis, label, extent in ((axes[0], 1, "z / m", (-5, 150, -5, 45)), (axes[1], 2, "y / m", (-5, 150, -5, 75))):
    picture = ax.imshow(fluence.mean(axis=axis).T, origin="lower", extent=extent, cmap="inferno", aspect="equal")
    ax.set(ylabel=label)
axes[1].set(xlabel="x / m")
axes[0].set(title="Fluence rate / (W/m²)")
fig.colorbar(picture, ax=axes)
plt.show()
