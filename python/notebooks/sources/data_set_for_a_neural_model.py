# %% [markdown]
# # A data set for a neural model
# Many states of one furnace for a surrogate model: inputs are temperatures, outputs are net powers with their errors by the exchange areas (that of the finite
# zones is not estimated). Exchange areas are
# computed once; each state costs milliseconds.
# %%
import time

import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

scene = zn.Scene("furnace", mode="thermal")
scene.surface(room=([0, 0, 0], [2, 2, 4]), name="wall", emissivity=0.8, temperature=900, patch_size=1.0)
scene.medium([0, 0, 0], [2, 2, 4], cells=[2, 2, 4], extinction=0.5, temperature=1400)
solver = zn.StateSolver(scene.exchange())
names = solver.names
generator = np.random.default_rng(7)
count = 60
inputs = generator.uniform(600, 1600, (count, len(names)))
outputs, errors = np.empty((count, len(names))), np.empty((count, len(names)))
begin = time.perf_counter()
for k, temperature in enumerate(inputs):
    solver.set_temperature(dict(zip(names, temperature)))
    state = solver.solve()
    outputs[k], errors[k] = state.by_name["net_power"], state.by_name["net_power_exchange_error"]
print(f"{count} states, {1e3 * (time.perf_counter() - begin) / count:.1f} ms each; columns: {names}")
np.savez("furnace-states.npz", temperature=inputs, net_power=outputs, net_power_exchange_error=errors, names=np.array(names))
# %% [markdown]
# Net powers are linear in T^4. A least-squares fit finds the total exchange areas back: a check that a trained model must pass too.
# %%
train, test = slice(0, 40), slice(40, count)
features = 5.670374419e-8 * inputs**4
weights, *_ = np.linalg.lstsq(features[train], outputs[train], rcond=None)
predicted = features[test] @ weights
fig, ax = plt.subplots(figsize=(4.5, 4), layout="constrained")
ax.plot(outputs[test].ravel() / 1e3, predicted.ravel() / 1e3, ".")
span = [outputs.min() / 1e3, outputs.max() / 1e3]
ax.plot(span, span, linewidth=0.8, color="grey")
ax.set(xlabel="solved net power / kW", ylabel="predicted / kW", title="Surrogate against states not seen")
plt.show()
print(f"largest deviation {np.abs(predicted - outputs[test]).max():.2e} W, largest error by the exchange areas {errors.max():.2e} W")
