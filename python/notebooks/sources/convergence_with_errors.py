# %% [markdown]
# # Convergence with errors
# A result has one total error, the sum of two parts: that of its equations, which is bounded, and that of its patches, which a second solve on patches of another
# size estimates.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn


def box(patch, tolerance=1e-3):
    scene = zn.Scene("box", mode="thermal")
    scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.5, temperature=300, patch_size=patch,
                  faces={"z0": {"temperature": 1000}})
    solution = scene.solve(tolerance=tolerance, discretization_error=True)
    table = solution.table
    k = list(table["name"]).index("wall.z0")
    return [table[name][k] for name in ("net_power", "net_power_error", "net_power_exchange_error", "net_power_discretization_error")]


sizes = [1.0, 0.5, 0.25, 0.125]
results = np.array([box(p) for p in sizes])
for patch, (power, error, equations, patches) in zip(sizes, results):
    print(f"patch {patch:5.3f} m: {power:9.2f} ± {error:.0f} W, of it {equations:.1e} W by the equations, about {patches:.0f} W by the patches")
# %%
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
ax.errorbar(sizes, results[:, 0] / 1e3, results[:, 1] / 1e3, marker="o", capsize=4)
ax.set(xscale="log", xlabel="edge of a patch / m", ylabel="net power / kW", title="Hot floor of a grey box")
ax.set_xticks(sizes, [str(s) for s in sizes])
ax.minorticks_off()
ax.ticklabel_format(axis="y", useOffset=False)
plt.show()
# %% [markdown]
# View factors too: the radius shrinks with the tolerance and holds against the closed form of opposite squares.
# %%
exact = 0.19982489569838746
square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
plates = (square + [[x, y, 1] for x, y, _ in square], [[0, 1, 2, 3], [7, 6, 5, 4]])
for tolerance in (1e-1, 1e-3, 1e-6):
    F = zn.view_factors(plates, tolerance=tolerance)
    error, radius = abs(F.matrix.toarray()[0, 1] - exact), F.radius.toarray()[0, 1]
    print(f"tolerance {tolerance:.0e}: error {error:.1e}, stated {radius:.1e}")
    assert error <= radius
