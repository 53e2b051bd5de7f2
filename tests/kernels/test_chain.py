"""The compiled chain against its plain twin, and where numba keeps what it compiles."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from numba.core import caching

import motionmend
import naive
from motionmend.bodies import skeleton as bodies
from motionmend.kernels.compile import compiled
from skeletons import skeletons


@settings(max_examples=30)
@given(skeletons())
def test_forward_is_its_twin(case):
    skeleton, rng = case
    q = rng.normal(size=(4, len(skeleton.dof_names))) * 2
    positions, rotations = bodies.forward(skeleton, q)
    twin_positions, twin_rotations = naive.chain_forward(skeleton, q)
    np.testing.assert_allclose(positions, twin_positions, rtol=0, atol=1e-12)
    np.testing.assert_allclose(rotations, twin_rotations, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(bodies.positions(skeleton, q), positions)


@settings(max_examples=30)
@given(skeletons())
def test_jacobian_is_the_finite_difference(case):
    skeleton, rng = case
    q = rng.normal(size=len(skeleton.dof_names))
    twin = naive.chain_jacobian(skeleton, q)
    np.testing.assert_allclose(bodies.jacobian(skeleton, q), twin, rtol=0, atol=1e-6)


@settings(max_examples=30)
@given(skeletons())
def test_a_missing_value_spreads_downwards_only(case):
    skeleton, rng = case
    q = rng.normal(size=(1, len(skeleton.dof_names)))
    positions, rotations = bodies.forward(skeleton, q)
    lost = int(rng.integers(len(skeleton.dof_names)))
    gap = q.copy()
    gap[0, lost] = np.nan
    gap_positions, gap_rotations = bodies.forward(skeleton, gap)

    owner, turns = skeleton.dof_joint[lost], skeleton.dof_kind[lost] == 0
    below = np.zeros(len(skeleton.names), dtype=bool)
    for j, parent in enumerate(skeleton.parents):
        below[j] = parent >= 0 and (below[parent] or parent == owner)
    # Of the joint itself: a turn leaves its own position unless it then moves along a turned axis.
    later = np.flatnonzero((skeleton.dof_joint == owner) & (np.arange(len(skeleton.dof_joint)) > lost))
    moved = below.copy()
    moved[owner] = not turns or bool((skeleton.dof_kind[later] == 1).any())
    turned = below.copy() if turns else np.zeros_like(below)
    turned[owner] |= turns

    np.testing.assert_array_equal(np.isnan(gap_positions[0]), np.repeat(moved[:, None], 3, axis=1))
    np.testing.assert_array_equal(gap_positions[0, ~moved], positions[0, ~moved])
    np.testing.assert_array_equal(np.isnan(gap_rotations[0]).all(axis=(1, 2)), turned)
    np.testing.assert_array_equal(gap_rotations[0, ~turned], rotations[0, ~turned])


KERNEL = """
import numba
from motionmend.kernels.compile import compiled
from motionmend.kernels import chain
import numpy as np

position = np.empty((1, 1, 3))
chain.positions(
    np.array([-1]), np.ones((1, 3)), np.array([0, 1]), np.eye(3)[:1], np.ones(1, np.uint8),
    np.full((1, 1), 2.0), position,
)
print(position.tolist(), chain.positions.stats.cache_path, repr(numba.config.CACHE_DIR))
"""


def run_without_writable_folders(tmp_path: Path, temporary: Path) -> subprocess.CompletedProcess[str]:
    """Run a kernel from a copy of the package beside which nothing can be written, without a home.

    Permissions do not stop an administrator, so files stand where numba would make its folders.
    """
    source = Path(motionmend.__file__).parent
    package = tmp_path / "install" / "motionmend"
    shutil.copytree(source / "kernels", package / "kernels", ignore=shutil.ignore_patterns("__pycache__"))
    for module in ("__init__.py", "arrays.py", "rooms.py"):
        shutil.copy(source / module, package / module)
    for folder in (package, package / "kernels"):
        (folder / "__pycache__").write_text("")
    blocked = tmp_path / "blocked"
    blocked.write_text("")
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    environment |= {
        "PYTHONPATH": str(package.parent),
        "HOME": str(blocked),
        "XDG_CACHE_HOME": str(blocked),
        "TMPDIR": str(temporary),
    }
    return subprocess.run(
        [sys.executable, "-c", KERNEL],
        env=environment,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )


@pytest.fixture(scope="module")
def read_only(tmp_path_factory):
    """The folder of such a copy, and what came of its kernel: to compile it takes two seconds."""
    folder = tmp_path_factory.mktemp("read-only")
    (folder / "tmp").mkdir()
    return folder, run_without_writable_folders(folder, folder / "tmp")


@pytest.mark.slow
def test_numba_itself_refuses_where_nothing_is_writable(read_only):
    """Guards the two tests below: without our fallback the decoration fails."""
    folder, before = read_only
    assert before.returncode == 0, before.stderr
    plain = folder / "install" / "motionmend" / "kernels" / "plain.py"
    plain.write_text("import numba\n\n@numba.njit(cache=True)\ndef one():\n    return 1\n")
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder / "install"),
        "HOME": str(folder / "blocked"),
        "XDG_CACHE_HOME": str(folder / "blocked"),
    }
    environment.pop("NUMBA_CACHE_DIR", None)
    run = subprocess.run(
        [sys.executable, "-c", "import motionmend.kernels.plain"],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert "no locator available" in run.stderr


@pytest.mark.slow
def test_a_read_only_install_caches_in_a_private_folder(read_only):
    folder, run = read_only
    temporary = folder / "tmp"
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("[[[3.0, 1.0, 1.0]]]")
    assert str(temporary) in run.stdout
    assert run.stdout.rstrip().endswith("''"), "numba's own setting must stay as it was"
    kept = list(temporary.glob("motionmend-kernels-*/*/*.nbc"))
    assert kept, "the machine code must be kept for the next run"
    if hasattr(os, "getuid"):
        folder = next(temporary.glob("motionmend-kernels-*"))
        assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.slow
def test_a_folder_others_may_write_to_is_not_trusted(tmp_path):
    if not hasattr(os, "getuid"):
        pytest.skip("no owners of files on this system")
    temporary = tmp_path / "tmp"
    planted = temporary / f"motionmend-kernels-{os.getuid()}"
    planted.mkdir(parents=True)
    planted.chmod(0o777)
    run = run_without_writable_folders(tmp_path, temporary)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("[[[3.0, 1.0, 1.0]]]")
    assert not list(planted.iterdir())


def test_a_full_disk_or_a_damaged_cache_costs_time_alone(tmp_path, monkeypatch):
    def kernel(x):
        return x + 1.0

    def full(cache_file, path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    with monkeypatch.context() as disk:
        disk.setattr(caching.IndexDataCacheFile, "_open_for_write", full)
        assert compiled(kernel)(1.0) == 2.0
    assert compiled(kernel)(1.0) == 2.0
    (index,) = tmp_path.rglob("*.nbi")
    index.write_bytes(b"")
    assert compiled(kernel)(1.0) == 2.0
    again = compiled(kernel)
    assert again(1.0) == 2.0
    assert again.stats.cache_hits, "what was compiled anew must be kept again"
