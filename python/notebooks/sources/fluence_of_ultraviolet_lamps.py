# %% [markdown]
# # Fluence of ultraviolet lamps in a room
# Two small lamps that emit diffusely at 222 nm, walls that reflect little, thin haze: the fluence rate in the air, with its error.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

room = zn.Scene("room", bands=1)
room.surface(room=([0, 0, 0], [4, 3, 2.6]), name="walls", reflectance=0.08, patch_size=0.75)
for name, x in (("lamp-a", 1.0), ("lamp-b", 2.9)):
    room.surface(rectangle=([x, 1.45, 2.55], [0, 0.1, 0], [0.1, 0, 0]), name=name, emission=10.0, reflectance=0.0)   # 0.1 W each
    room.emitter(name)
room.medium([0, 0, 0], [4, 3, 2.6], cells=[12, 9, 8], extinction=1e-3, albedo=0.5)
solution = room.solve(tolerance=0.02)
fields = solution.medium_arrays()
fluence = (fields["incident"] + fields["direct"])[..., 0]            # W/m2: reflected and scattered, and straight from the lamps
error = (fields["error"] + fields["direct_error"])[..., 0]
print(f"mean {1e2 * fluence.mean():.2f} ± {1e2 * error.mean():.2f} µW/cm2, largest error of a voxel {1e2 * error.max():.2f} µW/cm2 beside a lamp")
# %% [markdown]
# The fluence rate of a voxel is the mean of the radiance integrated over all directions. The level of the head, 1.6 m:
# %%
level = int(1.6 / 2.6 * 8)
fig, ax = plt.subplots(figsize=(5.5, 4), layout="constrained")
picture = ax.imshow(1e2 * fluence[:, :, level].T, origin="lower", extent=(0, 4, 0, 3), cmap="magma")
fig.colorbar(picture, label="fluence rate / (µW/cm²)")
ax.set(xlabel="x / m", ylabel="y / m", title="Two lamps, 1.6 m above the floor")
plt.show()
# %% [markdown]
# The log reduction of a virus with a susceptibility of 4 cm2/mJ after 10 minutes in still air, and in air that mixes completely:
# %%
dose = 1e-1 * fluence * 600                     # mJ/cm2
still = -np.log10(np.exp(-4.0 * dose).mean())
mixed = 4.0 * dose.mean() / np.log(10)
print(f"still air: {still:.2f}, mixed air: {mixed:.2f} decades")
