# %% [markdown]
# # Rows of solar panels
# Long rows of tilted modules above bright ground: the irradiance of the fronts and backs under a uniform sky, row by row, from view factors.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

rows, pitch, chord, tilt, height, length = 5, 6.0, 3.0, np.radians(30), 1.0, 40.0
points, faces, kind = [], [], []


def quad(corners, name):
    faces.append(np.arange(4) + len(points))
    points.extend(corners)
    kind.append(name)


for r in range(rows):
    low = np.array([r * pitch, 0.0, height])
    up = chord * np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    along = np.array([0.0, length, 0.0])
    gap = 0.02 * np.array([-np.sin(tilt), 0.0, np.cos(tilt)])       # front and back are two faces
    quad([low + gap, low + up + gap, low + up + along + gap, low + along + gap], f"front {r + 1}")
    quad([low, low + along, low + up + along, low + up], f"back {r + 1}")
x = np.linspace(-2 * pitch, (rows + 1) * pitch, 49)
for a, b in zip(x[:-1], x[1:]):
    quad([[a, -10, 0], [b, -10, 0], [b, length + 10, 0], [a, length + 10, 0]], "ground")
F = zn.view_factors((np.array(points), np.array(faces)), tolerance=1e-3)
print(F)
# %% [markdown]
# A sky that gives 100 W/m2 on free ground; reflectances 0.05 of modules and 0.3 of the ground. Irradiance H = E_sky + F (rho H).
# %%
reflectance = np.array([0.3 if k == "ground" else 0.05 for k in kind])
irradiance = np.linalg.solve(np.eye(len(F)) - F.matrix.toarray() * reflectance, 100.0 * F.sky)
front = irradiance[[k.startswith("front") for k in kind]]
back = irradiance[[k.startswith("back") for k in kind]]
ground = irradiance[[k == "ground" for k in kind]]
for r in range(rows):
    print(f"row {r + 1}: front {front[r]:5.1f}, back {back[r]:5.1f} W/m2, bifacial gain {back[r] / front[r]:.1%}")
# %%
fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
left.bar(np.arange(1, rows + 1) - 0.2, front, 0.4, label="front")
left.bar(np.arange(1, rows + 1) + 0.2, back, 0.4, label="back")
left.set(xlabel="row", ylabel="irradiance / (W/m²)", title="Modules", ylim=(0, 125))
left.legend(ncols=2)
right.plot(0.5 * (x[1:] + x[:-1]), ground)
right.set(xlabel="x / m", ylabel="irradiance / (W/m²)", title="Ground", ylim=(0, 105))
plt.show()
