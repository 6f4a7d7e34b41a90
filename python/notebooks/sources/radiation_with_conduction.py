# %% [markdown]
# # Radiation with conduction
# A fin loses heat by radiation to a colder plate and to the surroundings, and receives it by conduction from its root. Radiation gives the flux of each
# strip, conduction gives new temperatures, until both agree.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

length, width, thickness, conductivity = 0.1, 0.05, 0.001, 50.0   # m, W/(m K)
root, strips = 800.0, 20                                          # K
edges = np.linspace(0, length, strips + 1)
vertices = np.array([[x, y, 0.0] for x in edges for y in (0.0, width)])
faces = np.array([[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(strips)])

scene = zn.Scene("fin", mode="thermal")
scene.surface((vertices, faces), name="fin", emissivity=0.9, temperature=root, patch_size=0.1)
scene.surface(rectangle=([0, 0, 0.03], [0, width, 0], [length, 0, 0]), name="plate", emissivity=0.9, temperature=500.0, patch_size=0.05)
scene.surroundings(temperature=300.0)
solver = zn.StateSolver(scene.exchange())       # exchange areas are computed once
# %% [markdown]
# Finite volumes along the fin: k t T'' = q with T = root at x = 0 and no flux at the tip. The flux is linear in T near the last iterate, with the slope 4 e sigma T^3.
# %%
dx, sigma = length / strips, 5.670374419e-8
couple = conductivity * thickness / dx**2
matrix = couple * (2 * np.eye(strips) - np.eye(strips, k=1) - np.eye(strips, k=-1))
matrix[0, 0] += couple                          # half a cell to the root
matrix[-1, -1] -= couple
source = np.zeros(strips)
source[0] = 2 * couple * root
temperature = np.full(strips, root)
for step in range(50):
    solver.set_temperature(temperature, by="face")
    flux = solver.solve().by_face["net_flux"]
    slope = 4 * 0.9 * sigma * temperature**3
    new = np.linalg.solve(matrix + np.diag(slope), source - flux + slope * temperature)
    change = np.abs(new - temperature).max()
    temperature = new
    if change < 1e-6:
        break
print(step + 1, "steps, tip", round(temperature[-1], 2), "K")
# %% [markdown]
# What flows in at the root leaves as radiation:
# %%
inflow = conductivity * thickness * width * (root - temperature[0]) / (dx / 2)
print(f"conduction {inflow:.4f} W, radiation {(flux * dx * width).sum():.4f} W")
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
ax.plot(100 * (edges[:-1] + dx / 2), temperature, marker=".")
ax.set(xlabel="distance from the root / cm", ylabel="temperature / K", title="Fin that conducts and radiates")
plt.show()
