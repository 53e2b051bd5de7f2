"""
Learn from clean clips and fill a missing arm
=============================================

Nothing in a recording knows an arm that was hidden all the time. Clean clips of other people do: how they swing their
arms goes with their legs.
"""

import matplotlib.pyplot as plt
import numpy as np

import motionmend as mm
from motionmend.bodies.skeleton import positions

# %%
# Clips of six people teach a model. ``mm.save_model("studio.mend", model)`` keeps it.

clips = mm.samples.library(["walk"], seeds=range(6), seconds=6, fps=30)
model = mm.Denoiser().fit(clips)
print(f"learned from {model.clips} clips, {model.frames} frames")

# %%
# Somebody else walks. The left arm is missing throughout, the rest is noisy.

arm = ["lclavicle", "lhumerus", "lradius", "lwrist"]
truth = mm.samples.clip("walk", seconds=6, fps=30, seed=9)
spoiled = mm.corrupt(truth, noise=np.radians(2), drop=arm, seed=1).recording
repaired = model.repair(spoiled)
for sentence in repaired.warnings:
    print("warning:", sentence)

# %%
# How far are elbow and wrist from where they were? Beside the library: an arm that hangs still, in the mean pose of
# that very walk, which nobody would know.

body = truth.skeleton
joints = [body.names.index(name) for name in ("lradius", "lwrist")]
columns = np.isin(body.dof_joint, [body.names.index(name) for name in arm])
still = repaired.recording.q.copy()
still[:, columns] = truth.q[:, columns].mean(axis=0)
places = {"truth": truth.q, "from the library": repaired.recording.q, "hanging still": still}
places = {name: positions(body, q)[:, joints] for name, q in places.items()}
off = {name: 100 * np.linalg.norm(at - places["truth"], axis=2) for name, at in places.items()}
for name in ("hanging still", "from the library"):
    print(f"elbow and wrist, {name}: {off[name].mean():.1f} cm from the truth")

# %%
# The wrist before and behind the pelvis, along the way the person walks.

times = np.arange(truth.frames) / truth.fps
figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
for (name, at), colour in zip(places.items(), ("C2", "C0", "C5"), strict=True):
    axes.plot(times, 100 * (at[:, 1, 2] - truth.q[:, 2]), color=colour, label=name)
axes.set(title="Left wrist, missing throughout", xlabel="time, s", ylabel="before the pelvis, cm")
axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False)
plt.show()

assert not np.isnan(repaired.recording.q).any()
assert off["from the library"].mean() < off["hanging still"].mean()
