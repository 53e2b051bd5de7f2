import struct

import numpy as np
import pytest

from motionmend.errors import MismatchError, UsageError
from motionmend.report.figures import Panel, _apart, curves_figure, lines_figure, robust_figure, skeleton_figure

T = 120
TIMES = np.arange(T) / 60


def curves(path):
    truth = 20 * np.sin(TIMES * 3)
    noisy = truth + np.random.default_rng(0).normal(0, 2, T)
    gaps = (TIMES > 0.5) & (TIMES < 0.8)
    noisy[gaps] = np.nan
    panels = [
        Panel("knee", "°", {"noisy": noisy, "truth": truth, "repaired": truth + 0.3}, {"repaired": 0.5 + gaps}, gaps),
        Panel("hip", "°", {"noisy": noisy / 2, "other": truth}),
    ]
    curves_figure(path, TIMES, panels, title="Two joints")


def sticks(path):
    rng = np.random.default_rng(0)
    rest = np.array([[0, 1, 0], [0, 1.5, 0], [0.2, 1.4, 0.1], [0.1, 0.5, 0], [0.1, 0, 0]])
    clean = rest + np.stack([TIMES, 0 * TIMES, 0 * TIMES], axis=1)[:, None]
    noisy = clean + rng.normal(0, 0.05, clean.shape)
    noisy[30:40, 2] = np.nan
    marked = np.zeros(clean.shape[:2], bool)
    marked[60, 3] = True
    rows = {"noisy": noisy, "repaired": clean}
    up = np.array([0.0, 1.0, 0.0])
    parents = np.array([-1, 0, 1, 0, 3])
    skeleton_figure(
        path,
        rows,
        parents,
        frames=(10, 35, 60),
        fps=60,
        up=up,
        ghost=clean,
        marked={"repaired": marked},
        title="A walk",
    )


def lines(path):
    x = np.array([1.0, 2, 5, 10])
    methods = {f"method {i}": i + 0.1 * x for i in range(8)} | {"gone": np.full(4, np.nan)}
    spread = {"method 1": 0.1 * x}
    lines_figure(path, x, methods, xlabel="noise", ylabel="error", spread=spread, leading=["method 1"], log="x")


def robust(path):
    r = np.linspace(-4, 4, 101)
    w = np.exp(-(r**2) / 2)
    robust_figure(path, r, {"welsch": (1 - w, r * w, w), "square": (r**2 / 2, r, np.ones(101))}, title="Estimators")


@pytest.mark.slow
@pytest.mark.parametrize("draw", [curves, sticks, lines, robust])
def test_a_figure_is_a_png_without_date_or_version_and_always_the_same(tmp_path, draw):
    draw(tmp_path / "a.png")
    draw(tmp_path / "b.png")
    raw = (tmp_path / "a.png").read_bytes()
    assert raw == (tmp_path / "b.png").read_bytes()
    kinds, at = [], 8
    while at < len(raw):
        size, kind = struct.unpack(">I4s", raw[at : at + 8])
        kinds.append(kind)
        at += size + 12
    assert kinds[0] == b"IHDR"
    assert b"tEXt" not in kinds
    assert b"tIME" not in kinds
    width, height = struct.unpack(">II", raw[16:24])
    assert width > 600
    assert height > 250


@pytest.mark.slow
def test_the_user_s_own_settings_do_not_reach_a_figure(tmp_path):
    import matplotlib

    curves(tmp_path / "plain.png")
    with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "yellow", "savefig.dpi": 50}):
        curves(tmp_path / "odd.png")
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "odd.png").read_bytes()


def test_matplotlib_is_loaded_only_to_draw():
    import subprocess
    import sys

    code = "import sys, motionmend.report.figures; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_labels_are_pushed_apart_as_little_as_needed():
    heights = np.array([0.1, 0.12, 0.13, 0.5, 0.9, 0.91])
    apart = _apart(heights, 0.05)
    assert (np.diff(apart) >= 0.05 - 1e-12).all()
    assert apart[3] == 0.5
    assert apart[:3].mean() == pytest.approx(heights[:3].mean())
    assert np.array_equal(_apart(np.array([0.0, 0.5, 1.0]), 0.1), [0.0, 0.5, 1.0])


def test_what_does_not_fit_is_refused(tmp_path):
    with pytest.raises(MismatchError, match="120 values"):
        curves_figure(tmp_path / "f.png", TIMES, [Panel("knee", "°", {"noisy": TIMES[:-1]})])
    with pytest.raises(UsageError):
        curves_figure(tmp_path / "f.png", TIMES, [])
    with pytest.raises(UsageError):
        lines_figure(tmp_path / "f.png", TIMES, {}, xlabel="", ylabel="")
    with pytest.raises(MismatchError, match="one shape"):
        skeleton_figure(
            tmp_path / "f.png",
            {"a": np.zeros((3, 2, 3)), "b": np.zeros((4, 2, 3))},
            np.array([-1, 0]),
            frames=[0],
            fps=60,
            up=np.array([0, 0, 1.0]),
        )
    assert not list(tmp_path.iterdir())
