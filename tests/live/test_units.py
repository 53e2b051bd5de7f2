"""Bodies that no metres make, and some that only look so."""

import numpy as np
import pytest
from running import alone, ask, client, frame, moving, running, singles

from motionmend.bodies.joint_sets import KINECT20


@pytest.fixture(scope="module")
def live(model):
    with running(model) as found:
        yield found


@pytest.mark.parametrize("units", [100.0, 39.37])
def test_centimetres_about_the_pelvis_are_said_to_be_no_metres(live, model, units):
    positions = moving(KINECT20, 12)
    positions -= positions[:, :1]
    assert np.abs(units * positions).max() < 100.0  # so that no number is too large by itself
    wanted = alone(model, KINECT20, positions)
    with client(live.url) as connection:
        for k, joints in enumerate(positions):
            assert "centimetres" in ask(connection, frame(1000 + k, units * joints, t=k / 30.0))["error"]
            assert singles(ask(connection, frame(k, joints))["joints"]).reshape(20, 3) == pytest.approx(
                wanted[k], abs=1e-6
            )


def test_joints_thrown_far_off_or_left_at_the_sensor_make_no_giant(live):
    positions = moving(KINECT20, 6)
    positions[:, :, 2] += 8.0
    positions[1:, :9] += 60.0
    positions[3:, 9:19] = 0.0
    positions[5:, 3:] = np.nan
    with client(live.url) as connection:
        assert all("joints" in ask(connection, frame(k, joints)) for k, joints in enumerate(positions))
