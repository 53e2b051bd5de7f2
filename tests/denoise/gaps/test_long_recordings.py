"""Gaps of long recordings: what one gap costs hardly grows with all the frames there are."""

import numpy as np

from motionmend.denoise.gaps import markers_model
from motionmend.denoise.gaps.markers import _those_in
from motionmend.denoise.gaps.markers_model import TIME_PARTS, TIMES, Points, Relation, covariance


def test_those_in_rows_are_what_an_intersection_has():
    rng = np.random.default_rng(2)
    for count in (0, 1, 300):
        rows = np.unique(rng.integers(0, 400, count))
        asked = rng.integers(-20, 420, (2, 40))
        assert np.array_equal(_those_in(rows, asked), np.intersect1d(asked, rows))


def test_how_long_something_lasts_is_computed_once_for_all_gaps_of_a_long_recording(monkeypatch):
    asked, fps = [], 120.0
    one = Points(np.zeros((2, 3)), np.array([0, 90_000]), np.zeros(2, dtype=np.int64))
    how = Relation((slice(0, 3),), (1.0,), False, fps)
    computed = markers_model._lasting
    monkeypatch.setattr(markers_model, "_lasting", lambda away, scale: asked.append(len(away)) or computed(away, scale))
    markers_model._lasting_so_long.cache_clear()
    for later in range(20):
        amplitudes = np.concatenate([np.zeros(2), 1.0 + later + np.arange(TIME_PARTS), [0.1]])
        other = Points(np.zeros((1, 3)), np.array([30 + later]), np.zeros(1, dtype=np.int64))
        found = covariance(amplitudes, one, other, how)
        away = np.abs(one.frame - other.frame) / fps
        expected = sum(a * computed(away, s) for a, s in zip(amplitudes[2:-1], TIMES, strict=True))
        assert np.allclose(found[:, 0], expected, rtol=1e-12)
    assert len(asked) == len(TIMES)
