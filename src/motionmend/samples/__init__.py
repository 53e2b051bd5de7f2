"""A synthetic performer: recordings of its own for the demo and for tests without outside files.

Joint curves follow published gait norms, feet stand where they land, and every clip is somebody else's by its seed.
"""

from .body import skeleton
from .markers import markers
from .performer import ACTIONS, clip, library

__all__ = ["ACTIONS", "clip", "library", "markers", "skeleton"]
