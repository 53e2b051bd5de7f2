"""Section 5.3: time a frame, against scikit-learn's full Gaussian process"""

from pathlib import Path
from time import perf_counter

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel

from .common import Findings
from .correct_common import ABOUT, episodes, folds, kinect_in, learned, samples_of

FRAMES = 400


def run(mocap: Path, pictures: Path) -> Findings:
    """Milliseconds a live frame, all joints and terms, one thread."""
    del pictures
    kinect = kinect_in(mocap)
    people = folds(episodes(kinect))[0]
    start = perf_counter()
    model = learned.__wrapped__(kinect, people)
    learning = perf_counter() - start
    sensors = [one.pair.sensor for one in episodes(kinect) if one.person in people]
    spent: dict[bool, list[float]] = {}
    for online in (False, True):
        spent[online] = []
        for sensor in sensors:
            state = model.start(sensor.names, online)
            for t, positions in enumerate(sensor.positions):
                start = perf_counter()
                state, _ = model.step(state, positions, None, float(sensor.times[t]))
                spent[online].append(1e3 * (perf_counter() - start))
            if len(spent[online]) > FRAMES:
                break
    same = samples_of(model, [one.pair for one in episodes(kinect) if one.person not in people])
    x = same.postures.reshape(len(same.postures), -1)
    y = np.nan_to_num(same.offsets).reshape(len(x), -1)
    full = GaussianProcessRegressor(RBF(1.0) + WhiteKernel(0.01), optimizer=None).fit(x, y)
    theirs = []
    for t in range(20):
        start = perf_counter()
        full.predict(x[t : t + 1], return_std=True)
        theirs.append(1e3 * (perf_counter() - start))
    quick = np.array(spent[False][20:])
    return Findings(
        {
            "median": float(np.median(quick)),
            "p95": float(np.percentile(quick, 95)),
            "online_median": float(np.median(spent[True][20:])),
            "online_p95": float(np.percentile(spent[True][20:], 95)),
            "full": float(np.median(theirs)),
            "faster": float(np.median(theirs) / np.median(quick)),
            "learning": learning,
            "frames": float(model.frames),
        },
        (
            ABOUT,
            "The full process is scikit-learn's, on all the samples the corrector learned from, mean and deviation of all joints together.",
        ),
    )
