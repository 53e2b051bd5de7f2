"""
Fill gaps of markers
====================

Optical markers get hidden. The markers about a gap tell where the hidden one must be, and clips of the same marker set
tell how they belong together.
"""

import matplotlib.pyplot as plt
import numpy as np

import motionmend as mm

# %%
# 41 markers on the synthetic performer. A studio's own would come from ``mm.read("take.c3d")``.

clips = [mm.samples.markers(clip) for clip in mm.samples.library(["walk", "turn"], range(3), seconds=6, fps=60)]
model = mm.Denoiser().fit(clips)
truth = mm.samples.markers(mm.samples.clip("walk", seconds=4, fps=60, seed=9))
spoiled = mm.corrupt(truth, noise=0.002, outliers=0.01, gaps=0.15, seed=2)

# %%
# Repaired by the model, and for comparison by the straight lines that are often drawn across gaps. Lines need samples
# on both sides; gaps at an end, which they leave open, do not count.

repaired = model.repair(spoiled.recording)
lines = mm.repair_without_model(spoiled.recording, "linear")
inside = spoiled.missing & lines.recording.present
drawn, filled = (
    100 * np.linalg.norm(one.recording.positions - truth.positions, axis=2)[inside] for one in (lines, repaired)
)
print("samples:", repaired.counts())
print(f"inside the gaps, from the truth: {drawn.mean():.2f} cm by lines, {filled.mean():.2f} cm by the model")
print(f"standard deviation of a coordinate that the model states there: {100 * repaired.std[inside].mean():.2f} cm")

# %%
# The height of the marker that was hidden longest. Gaps are shaded.

worst = int(spoiled.missing.sum(axis=0).argmax())
shown = {"recorded": spoiled.recording, "truth": truth, "by lines": lines.recording, "repaired": repaired.recording}
height = {name: 100 * one.positions[:, worst, 1] for name, one in shown.items()}
height["by lines"] = np.where(spoiled.missing[:, worst], height["by lines"], np.nan)
times = np.arange(truth.frames) / truth.fps
low, high = height["truth"].min() - 1, height["truth"].max() + 1

figure, axes = plt.subplots(figsize=(8, 3.6), layout="constrained")
axes.fill_between(times, low, high, where=spoiled.missing[:, worst], color="C5", alpha=0.15, lw=0)
for (name, values), colour, drawing in zip(
    height.items(), ("C1", "C2", "C5", "C0"), (".", "-", "--", "-"), strict=True
):
    axes.plot(times, values, drawing, ms=3, color=colour, label=name)
axes.set(title=f"Marker {truth.names[worst]}", xlabel="time, s", ylabel="height, cm", ylim=(low, high))
axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=4, frameon=False)
plt.show()

assert repaired.recording.present.all()
assert filled.mean() < 0.5 * drawn.mean()
