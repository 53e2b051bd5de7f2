"""
Correct a sensor's skeleton live
================================

The skeleton that a depth sensor reports is off by centimetres, always in the same way, and by decimetres where a limb
is hidden from it. Pairs of what it said and what was true teach both.
"""

import matplotlib.pyplot as plt
import numpy as np

import motionmend as mm
from motionmend.bodies.truth_joints import joints_of_motion
from motionmend.evaluate.sensor_failures import fail

# %%
# A sensor is made up: it draws every joint towards the pelvis, has a bias for each, and trembles.

SIDED = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")
NAMES = ("pelvis", "spine", "neck_base", "head", *(f"{side}_{joint}" for side in "lr" for joint in SIDED))
BIAS = np.random.default_rng(0).normal(0, 0.02, (len(NAMES), 3))  # m


def recorded(action: str, seed: int) -> mm.Pair:
    """What the sensor says of the synthetic performer, and the truth."""
    joints = joints_of_motion(mm.samples.clip(action, seconds=6, fps=30, seed=seed))
    true = joints.positions[:, [joints.names.index(name) for name in NAMES]]
    tremble = np.random.default_rng(seed).normal(0, 0.004, true.shape)
    said = true[:, :1] + 0.93 * (true - true[:, :1]) + BIAS + tremble
    return mm.Pair(mm.Postures(NAMES, said, joints.times), mm.Postures(NAMES, true, joints.times))


# %%
# Six people teach. Pairs of files are what ``motionmend fit corrector`` learns from.

model = mm.Corrector().fit([recorded(action, seed) for seed in range(6) for action in ("walk", "reach")])

# %%
# Somebody else is recorded, and the sensor fails: limbs are guessed somewhere near the trunk, or taken for those of the
# other side. Live, one frame goes in and comes out right at once.

pair = recorded("walk", seed=9)
failed = fail(pair.sensor, share=0.3, states=False, seed=3)
state = model.start(NAMES)
corrected = []
for positions, time in zip(failed.postures.positions, failed.postures.times, strict=True):
    state, frame = model.step(state, positions, None, time)
    corrected.append(frame)

# %%
# How far off both are, and how far the sensor was believed.

hit = failed.affected
believed = np.array([frame.reliability for frame in corrected])
places = failed.postures.positions, np.array([frame.positions for frame in corrected])
raw, right = (100 * np.linalg.norm(one - pair.truth.positions, axis=2) for one in places)
print(f"where it sees: {raw[~hit].mean():.1f} -> {right[~hit].mean():.1f} cm, reliability {believed[~hit].mean():.2f}")
print(f"where it fails: {raw[hit].mean():.1f} -> {right[hit].mean():.1f} cm, reliability {believed[hit].mean():.2f}")

# %%
# The joint that failed longest. Shaded is where the sensor fails.

worst = int(hit.sum(axis=0).argmax())
times, top = pair.sensor.times, 1.05 * raw[:, worst].max()
figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
axes.fill_between(times, 0, top, where=hit[:, worst], color="C5", alpha=0.15, lw=0)
axes.plot(times, raw[:, worst], color="C1", label="sensor")
axes.plot(times, right[:, worst], color="C0", label="corrected")
axes.set(title=f"Joint {NAMES[worst]}", xlabel="time, s", ylabel="distance from the truth, cm", ylim=(0, top))
axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
plt.show()

assert right[~hit].mean() < 0.5 * raw[~hit].mean()
assert right[hit].mean() < 0.5 * raw[hit].mean()
