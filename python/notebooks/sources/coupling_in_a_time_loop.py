# %% [markdown]
# # Coupling in a time loop
# A thin box cools from within: each wall has a heat capacity; radiation between the walls is solved in each step from exchange areas that are computed once.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

scene = zn.Scene("box", mode="thermal")
scene.surface(room=([0, 0, 0], [1, 1, 0.5]), name="wall", emissivity=0.8, temperature=300, patch_size=0.5)
areas = scene.exchange()
solver = zn.StateSolver(areas)
names = solver.names
size = np.array([solver.size[solver.name_index == k].sum() for k in range(len(names))])
print(names, size)
# %%
capacity = 7800 * 500 * 0.002                   # J/(m2 K): 2 mm of steel
temperature = np.where(np.array(names) == "wall.z0", 900.0, 300.0)
step, history = 5.0, [temperature]
for _ in range(120):
    solver.set_temperature(dict(zip(names, temperature)))
    flux = solver.solve().by_name["net_flux"]   # W/m2 that leaves
    temperature = temperature - step * flux / capacity
    history.append(temperature)
history = np.array(history)
energy = capacity * history @ size
print(f"energy lost over all steps: {abs(energy[-1] / energy[0] - 1):.1e}")
# %%
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
time = step * np.arange(len(history)) / 60
for k in (names.index("wall.z0"), names.index("wall.z1"), names.index("wall.x0")):
    ax.plot(time, history[:, k], label=names[k])
ax.set(xlabel="time / min", ylabel="temperature / K", title="Walls that exchange heat")
ax.legend()
plt.show()
