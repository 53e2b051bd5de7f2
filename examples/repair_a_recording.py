"""
Repair a recording
==================

A walk was recorded with noise, outliers and gaps. The default method is told nothing about them and knows no other
recording: it finds how noisy each channel is, which samples are outliers and how lively the motion is.
"""

import matplotlib.pyplot as plt
import numpy as np

import motionmend as mm

# %%
# The synthetic performer walks. Three degrees of noise, one outlier in twenty samples and a few gaps are added, so that
# the truth is known. A recording of your own comes from ``mm.read("walk.bvh")``.

truth = mm.samples.clip("walk", seconds=6, fps=60, seed=9)
spoiled = mm.corrupt(truth, noise=np.radians(3), outliers=0.05, gaps=0.03, seed=1)
repaired = mm.repair_without_model(spoiled.recording, "adaptive")

# %%
# Every sample says where it is from, and has a standard deviation.

before = mm.compare(truth, spoiled.recording).rms_deg
after = mm.compare(truth, repaired.recording).rms_deg
found = repaired.origin == mm.Origin.REPAIRED
angles = repaired.recording.present & (truth.skeleton.dof_kind == 0)  # without the root's translations
within = (np.abs(repaired.recording.q - truth.q) <= repaired.std)[angles].mean()
print("samples:", repaired.counts())
print(f"outliers replaced: {found[spoiled.outlier].mean():.0%} of those there are")
print(f"error of the body's angles: {before:.2f} -> {after:.2f} degrees")
print(f"errors within one standard deviation: {within:.0%}, about 68 % are wanted")

# %%
# Half of the recording of one knee, and how far the repair is from the truth. The band is one standard deviation to
# either side.

knee = truth.channels.index("ltibia.rx")
times = np.arange(truth.frames) / truth.fps
noisy, clean, mended = (np.degrees(one.q[:, knee]) for one in (spoiled.recording, truth, repaired.recording))
std, replaced = np.degrees(repaired.std[:, knee]), found[:, knee]

figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5), sharex=True, height_ratios=(2, 1), layout="constrained")
above.plot(times, noisy, ".", color="C1", ms=3, label="recorded")
above.plot(times[replaced], noisy[replaced], "o", mfc="none", color="C1", label="found to be an outlier")
above.plot(times, clean, color="C2", label="truth")
above.plot(times, mended, color="C0", label="repaired")
above.set(title="Left knee", ylabel="angle, degrees")
above.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=4, frameon=False)
below.fill_between(times, -std, std, color="C0", alpha=0.25, lw=0)
below.plot(times, mended - clean, color="C0")
below.set(title="Repaired less truth", xlabel="time, s", ylabel="degrees", xlim=(0, 3))
plt.show()

assert after < 0.5 * before
assert found[spoiled.outlier].mean() > 0.8
