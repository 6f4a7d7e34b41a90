# %% [markdown]
# # Relighting with sliders
# Each lamp is a light group; a solution is scaled by group without another solve. With `ipywidgets` the factors are sliders.
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

scene = zn.Scene("room")
scene.surface(room=([0, 0, 0], [4, 3, 2.5]), name="walls", reflectance=0.6, patch_size=0.4)
scene.surface(box=([1.5, 1.2, 0], [2.4, 1.9, 0.9]), name="table", reflectance=[0.6, 0.4, 0.2], patch_size=0.4)
scene.surface(rectangle=([0.6, 1.2, 2.45], [0, 0.5, 0], [0.5, 0, 0]), name="warm", emission=[60, 40, 20], reflectance=0.0)
scene.surface(rectangle=([2.9, 1.2, 2.45], [0, 0.5, 0], [0.5, 0, 0]), name="cold", emission=[20, 35, 60], reflectance=0.0)
scene.medium([0, 0, 0], [4, 3, 2.5], cells=[6, 5, 4], extinction=0.03, albedo=0.9)
scene.camera([0.3, 0.2, 1.6], [2.2, 1.8, 1.0], fov=75)
solution = scene.solve(tolerance=0.05)
print(solution.light_groups)
# %%
white = np.quantile(solution.render(size=(120, 90)), 0.95)


def picture(warm, cold):
    light = solution.relight(warm=warm, cold=cold).render(size=(240, 180))
    return np.clip(light / white, 0, 1) ** (1 / 2.2)


fig, axes = plt.subplots(1, 3, figsize=(10, 2.7), layout="constrained")
for ax, (warm, cold) in zip(axes, ((1, 0), (0, 1), (0.6, 0.6))):
    ax.imshow(picture(warm, cold))
    ax.set(title=f"warm {warm}, cold {cold}", xticks=[], yticks=[])
plt.show()
# %% [markdown]
# With sliders, where `ipywidgets` is installed:
# %%
try:
    import ipywidgets
except ImportError:
    print("pip install ipywidgets for sliders")
else:
    def show(warm=1.0, cold=1.0):
        plt.imshow(picture(warm, cold))
        plt.axis("off")
        plt.show()

    ipywidgets.interact(show, warm=(0.0, 2.0, 0.1), cold=(0.0, 2.0, 0.1))
