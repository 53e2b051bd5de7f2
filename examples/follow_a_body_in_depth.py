"""
Follow a body in depth images
=============================

A depth camera sees one side of a person, with noise, and an arm may be behind the body. The tracker fits a body to each
image; where nothing of a limb is seen, poses of a library hold it, and its standard deviation says so.
"""

import matplotlib.pyplot as plt
import numpy as np

import motionmend as mm
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import LANDMARKS, landmarks
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.evaluate.scenes import strange, view
from motionmend.evaluate.strangers import stranger

# %%
# Poses of clips are the library. The detector, which finds a person in the first image, takes longer
# to learn and is left out: the first pose is given instead.

library = mm.samples.library(["walk", "reach"], seeds=range(3), seconds=4, fps=30)
model = mm.TrackerModel.fit(library, detector=False)

# %%
# Somebody whom the library does not know walks past the camera. Their surface is not the tracker's
# own, and the depth has the noise of a Kinect. Images from files come from ``mm.read_depth("take/")``.

walk = mm.samples.clip("walk", seconds=1.4, fps=30, seed=9)
seen = view(np.median(walk.q[:, :3], axis=0), walk.skeleton.up, distance=3.2, yaw=60)
frames = list(strange(walk, stranger(walk.skeleton, seed=1), seen, KINECT, seed=0))
person = performer_of(walk.skeleton)  # their lengths, but an average adult's widths
poses = poses_of(walk, person).poses.moved(seen.turn, seen.shift)
truth = np.array([landmarks(person, poses[t]) for t in range(len(frames))])

# %%
# A recording is followed in one call, in which later images set earlier ones right.

tracked = mm.track.follow(model, frames, person, poses[0])

# %%
# Live, a state goes in with an image, and the next state and an estimate come out.

state = mm.track.start(model, mm.track.settings_of(), frames[0], person, poses[0])
live = []
for frame in frames:
    state, estimate = mm.track.step(model, mm.track.settings_of(), state, frame)
    live.append(estimate.landmarks)

error, live_error = (100 * np.linalg.norm(one - truth, axis=2) for one in (tracked.joints, live))
print(f"recording: {error.mean():.1f} cm from the truth, out of sight {error[tracked.held].mean():.1f} cm")
print(f"live: {live_error.mean():.1f} cm, out of sight {live_error[tracked.held].mean():.1f} cm")

# %%
# An image in which the far wrist is out of sight, and how far that wrist is from the truth.

wrist = LANDMARKS.index("r_wrist")
shown = int(np.median(np.flatnonzero(tracked.held[:, wrist])))
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), width_ratios=(1, 1.3), layout="constrained")
image = left.imshow(frames[shown].depth, cmap="Greys")
figure.colorbar(image, ax=left, label="depth, m")
for places, colour, mark, name in ((truth, "C2", "o", "truth"), (tracked.joints, "C0", "x", "tracked")):
    left.plot(*KINECT.project(places[shown]).T, mark, mfc="none", color=colour, ms=5, label=name)
left.set(title=f"At {tracked.times[shown]:.2f} s", xlabel="pixels", ylabel="pixels", xlim=(80, 240), ylim=(225, 40))
left.legend(loc="upper right", frameon=False)
right.plot(tracked.times, live_error[:, wrist], color="C5", label="live")
right.plot(tracked.times, error[:, wrist], color="C0", label="recording")
right.plot(tracked.times, 100 * tracked.std[:, wrist], "--", color="C0", label="its deviation")
right.set(title="Far wrist", xlabel="time, s", ylabel="distance from the truth, cm", ylim=(0, None))
right.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False)
plt.show()

assert tracked.seen.all()
assert error.mean() < 3
