"""What a user pays before anything is done: the import and the first help text."""

import resource
import subprocess
import sys

import pytest

HEAVY = ("numba", "sklearn", "matplotlib", "ezc3d", "scipy", "cv2")


def loaded_by(code: str) -> set[str]:
    """Top-level names of the modules a fresh Python holds after running `code`."""
    report = "import sys; print('\\n'.join({n.split('.')[0] for n in sys.modules}), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", f"{code}\n{report}"], capture_output=True, text=True, check=True)
    return set(done.stderr.split())


def seconds(*command: str) -> float:
    """Fewest seconds of the processor in five runs: a busy machine does not add to them."""
    best = float("inf")
    for _ in range(5):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *command], capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        best = min(best, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return best


def test_import_loads_nothing_heavy() -> None:
    assert loaded_by("import motionmend").isdisjoint(HEAVY)


def test_import_takes_under_a_third_of_a_second() -> None:
    assert seconds("-c", "import motionmend") - seconds("-c", "pass") < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("argv", [["--help"], ["denoise", "--help"], ["--version"]])
def test_help_loads_nothing_heavy(argv: list[str]) -> None:
    assert loaded_by(f"from motionmend.cli import main; main({argv!r})").isdisjoint(HEAVY)


@pytest.mark.slow
def test_help_comes_at_once() -> None:
    """Not much later than the libraries it cannot do without: seconds would say more of the machine than of us."""
    assert seconds("-m", "motionmend", "--help") < 3.0 * seconds("-c", "import numpy, cyclopts")


def test_every_public_name_is_there() -> None:
    import motionmend

    for name in motionmend.__all__:
        assert getattr(motionmend, name) is not None
    with pytest.raises(AttributeError, match="nothing"):
        _ = motionmend.nothing
