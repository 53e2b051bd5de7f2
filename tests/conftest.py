"""What every test may ask for: the folder of real recordings, a seeded generator, a browser."""

import gc
import os
import shutil
import signal
import sys
from collections.abc import Generator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the workers have the cores: threads of theirs wait for each other

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # run in a shell's background; tests of Ctrl-C need to hear it
    signal.signal(signal.SIGINT, signal.default_int_handler)
settings.register_profile("motionmend", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("motionmend")


def pytest_configure(config: pytest.Config) -> None:
    """Where Python is told to leave no bytecode beside the sources it goes into pytest's own cache, for otherwise each
    of the hundred processes of the tests compiles all that it imports."""
    if sys.dont_write_bytecode and hasattr(config, "cache"):
        sys.dont_write_bytecode = False
        sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"] = str(config.cache.mkdir("bytecode"))
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is collected stays: to look through it for waste again and again is a fifth of the work."""
    gc.disable()
    collected = yield
    gc.freeze()
    gc.enable()
    return collected


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real recordings that MOTIONMEND_DATA names."""
    folder = os.environ.get("MOTIONMEND_DATA")
    if not folder:
        pytest.skip("MOTIONMEND_DATA is not set: real recordings are not part of the project")
    path = Path(folder)
    if not (path / "mocap").is_dir():
        pytest.fail(f"MOTIONMEND_DATA={folder} holds no folder 'mocap'")
    return path


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator that starts the same in every test."""
    return np.random.default_rng(20121)


@pytest.fixture(scope="module")
def browser():
    """Debian's chromium, without a window and without a word to anybody.

    One for a module, not for all: while it is open its event loop runs in this thread, and others that need one fail.
    """
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed: pages cannot be tried in a browser")
    quiet = ("gpu", "quic", "background-networking", "component-update", "sync")
    arguments = ["--no-sandbox", "--no-first-run", *(f"--disable-{one}" for one in quiet)]
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield browser
        browser.close()
