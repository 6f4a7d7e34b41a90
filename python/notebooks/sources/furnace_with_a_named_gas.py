# %% [markdown]
# # A furnace with a named gas
# A gas of water vapour and carbon dioxide between walls of known temperature, with the coefficients of a published weighted sum of grey gases.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

mixture = zn.gas_properties("wsgg-bordbar-2020", h2o=0.2, co2=0.1, temperature=1500, lengths=[0.1, 0.3, 1, 3, 10])
for row in mixture["emissivity"]:
    print(f"{row['length']:5.1f} m: emissivity {row['emissivity']:.4f}")
# %%
def furnace(h2o):
    scene = zn.Scene("furnace", mode="thermal")
    scene.surface(room=([0, 0, 0], [1, 1, 3]), name="wall", emissivity=0.8, temperature=800, patch_size=0.5)
    scene.medium([0, 0, 0], [1, 1, 3], cells=[2, 2, 6], temperature=1500,
                 gas=zn.Gas("wsgg-bordbar-2020", h2o=h2o, co2=0.1))
    return scene.solve(tolerance=1e-2, discretization_error=True)


fractions = [0.05, 0.1, 0.2, 0.3]
solutions = [furnace(x) for x in fractions]
walls = [[name.startswith("wall") for name in s.table["name"]] for s in solutions]
power = np.array([-s.table["net_power"][w].sum() for s, w in zip(solutions, walls)]) / 1e3
error = np.array([s.table["net_power_error"][w].sum() for s, w in zip(solutions, walls)]) / 1e3
# %% [markdown]
# The power that the walls receive. Its error is that of the equations plus the estimated one of the patches and voxels; that of the gas model is not part of it.
# %%
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
ax.errorbar(fractions, power, error, marker="o", capsize=3)
ax.set(xlabel="mole fraction of water vapour", ylabel="power to the walls / kW", title="Gas of 1500 K, walls of 800 K")
plt.show()
for x, p, e in zip(fractions, power, error):
    print(f"{x:.2f}: {p:.1f} ± {e:.1f} kW")
