# %% [markdown]
# # From trimesh to a picture
# A mesh of trimesh in a lit room with thin haze, drawn by zonal.
# %%
import matplotlib.pyplot as plt
import numpy as np
import trimesh
import zonal as zn

ball = trimesh.creation.icosphere(subdivisions=2, radius=0.6)
ball.apply_translation([1.35, 1.7, 0.62])
block = trimesh.creation.box(extents=[0.7, 0.7, 1.2])
block.apply_translation([2.65, 2.1, 0.61])

scene = zn.Scene("room")
scene.surface(room=([0, 0, 0], [4, 3, 2.5]), name="room", reflectance=0.7, patch_size=0.4,
              faces={"x0": {"reflectance": [0.7, 0.2, 0.15]}, "x1": {"reflectance": [0.2, 0.6, 0.25]}})
scene.surface(ball, name="ball", reflectance=[0.8, 0.75, 0.6], patch_size=0.4)
scene.surface(block, name="block", reflectance=[0.35, 0.45, 0.8], patch_size=0.4)
scene.surface(rectangle=([1.5, 1.2, 2.48], [0, 0.8, 0], [1.0, 0, 0]), name="lamp", emission=40.0, reflectance=0.0)
scene.medium([0, 0, 0], [4, 3, 2.5], cells=[8, 6, 5], extinction=0.05, albedo=0.9)
scene.camera([2.0, 0.1, 1.5], [2.0, 2.2, 0.95], fov=88)
solution = scene.solve(tolerance=0.05)
print(solution)
# %%
picture = solution.render(size=(360, 270), samples=4)
light = picture / np.quantile(picture, 0.95)
fig = plt.figure(figsize=(6, 4.5), layout="constrained")
plt.imshow(np.clip(light, 0, 1) ** (1 / 2.2))
plt.axis("off")
plt.show()
