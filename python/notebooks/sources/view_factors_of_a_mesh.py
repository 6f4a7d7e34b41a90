# %% [markdown]
# # View factors of a mesh
# A sphere of triangles in a box: all view factors with an error radius for each, closed rows, and total exchange factors.
# %%
import numpy as np
import zonal as zn


def sphere(n):
    """A unit sphere of triangles, fronts outside."""
    a, b = np.meshgrid(np.pi * np.arange(n + 1) / n, np.pi * np.arange(2 * n) / n, indexing="ij")
    vertices = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1).reshape(-1, 3)
    at = lambda i, j: 2 * n * i + j % (2 * n)
    faces = [[at(i, j), at(i + 1, j), at(i + 1, j + 1)] for i in range(n - 1) for j in range(2 * n)]
    faces += [[at(i, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(1, n) for j in range(2 * n)]
    return vertices, np.array(faces)


def floor_of_squares(m, half=2.0):
    """Squares in the plane z = -half that look up."""
    x = np.linspace(-half, half, m + 1)
    vertices = np.stack([*np.meshgrid(x, x, indexing="ij"), np.full((m + 1, m + 1), -half)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(m), np.arange(m), indexing="ij")
    first = ((m + 1) * i + j).reshape(-1, 1)
    return vertices, first + [0, m + 1, m + 2, 1]


ball, triangles = sphere(8)
ground, squares = floor_of_squares(16)
mesh = (np.concatenate([ball, ground]), np.concatenate([triangles, squares[:, [0, 1, 2]] + len(ball), squares[:, [0, 2, 3]] + len(ball)]))
F = zn.view_factors(mesh)
F
# %% [markdown]
# `F.matrix` is sparse; `F.radius` has its error radii. Here nothing encloses the faces, so that each row is completed by the sky and the ground.
# %%
print(F)
print("row sums", F.row_sums.min(), "to", F.row_sums.max(), "| largest radius", F.radius.data.max())
both = F.combined(["sphere"] * len(triangles) + ["floor"] * (2 * len(squares)))
print(both.names, both.matrix.toarray().round(5).tolist(), "sky", both.sky.round(5))
# %% [markdown]
# The share of the sphere in the view of each part of the floor:
# %%
import matplotlib.pyplot as plt

count = len(squares)
seen = np.asarray(F.matrix.toarray()[len(triangles):, :len(triangles)].sum(axis=1))
mean = 0.5 * (seen[:count] + seen[count:]).reshape(16, 16)
fig, ax = plt.subplots(figsize=(5, 4), layout="constrained")
picture = ax.imshow(mean.T, origin="lower", extent=(-2, 2, -2, 2), cmap="viridis")
fig.colorbar(picture, label="view factor to the sphere")
ax.set(xlabel="x / m", ylabel="y / m", title="Floor below a sphere")
plt.show()
# %% [markdown]
# Total exchange factors of grey surfaces (script F): from the sphere to the floor with reflections.
# %%
values, radii = both.script_f([0.8, 0.5])
print(f"script F from sphere to floor: {values[0, 1]:.5f} ± {radii[0, 1]:.1e}")
