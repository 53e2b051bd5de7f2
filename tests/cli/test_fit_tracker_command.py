"""`motionmend fit tracker`, on clips that are not whole."""

import re
from pathlib import Path

import numpy as np
from commands import Command

from motionmend import samples
from motionmend.io import write


def test_poses_that_lack_channels_are_left_out_and_it_is_said(cli: Command, tmp_path: Path) -> None:
    clip = samples.clip("reach", seconds=2.0, seed=4)
    q = clip.q.copy()
    q[40:60, 8] = np.nan
    write(tmp_path / "gap.bvh", clip.with_q(q))
    ran = cli("fit", "tracker", tmp_path / "gap.bvh", "-o", tmp_path / "m.mend", "--images", "0")
    assert ran.code == 0
    assert re.search(r"gap\.bvh\): 5 of 60 poses lack channels and are left out", ran.err)
    assert "55 poses, no images" in ran.err
