import numpy as np

from motionmend.report.edges import rigid_edges


def two_bones(rng, frames=200):
    """Two stiff triangles that swing against each other far more than skin does."""
    corners = np.array([[0.0, 0, 0], [0.2, 0, 0], [0, 0.15, 0]])
    turn = np.linspace(0, 3, frames)
    rotation = np.zeros((frames, 3, 3))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(turn)
    rotation[:, 0, 1], rotation[:, 1, 0] = -np.sin(turn), np.sin(turn)
    rotation[:, 2, 2] = 1
    swinging = corners @ rotation.transpose(0, 2, 1) + [0, 0, 0.5]
    swinging[:, :, 2] += 0.3 * np.sin(3 * turn)[:, None]
    return np.concatenate([np.broadcast_to(corners, (frames, 3, 3)), swinging], axis=1) + rng.normal(
        0, 0.001, (frames, 6, 3)
    )


def test_only_markers_of_one_bone_are_joined(rng):
    names = ["a", "b", "c", "d", "e", "f"]
    edges = {tuple(e) for e in rigid_edges(names, two_bones(rng)).tolist()}
    assert edges == {(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)}


def test_gaps_and_rare_outliers_change_nothing(rng):
    names = ["a", "b", "c", "d", "e", "f"]
    positions = two_bones(rng)
    clean = rigid_edges(names, positions)
    positions[rng.random(positions.shape[:2]) < 0.01] += 0.8
    positions[50:90, 1] = np.nan
    assert np.array_equal(rigid_edges(names, positions), clean)


def test_feet_that_stand_still_are_not_joined(rng):
    feet = np.array([[0.0, 0, 0], [0, 0.12, 0], [0.3, 0, 0], [0.3, 0.12, 0]])
    sway = np.cumsum(rng.normal(0, 0.002, (300, 1, 3)), axis=0) * [[[0.0], [0.0], [1.0], [1.0]]]
    edges = rigid_edges(["LHEE", "LTOE", "RHEE", "RTOE"], feet + sway * 0.5)
    assert edges.tolist() == [[0, 1], [2, 3]]


def test_a_marker_never_seen_has_no_edge_and_raises_no_warning(rng):
    positions = two_bones(rng)
    positions[:, 2] = np.nan
    assert 2 not in rigid_edges(["a", "b", "c", "d", "e", "f"], positions)
    assert rigid_edges(["a"], positions[:, :1]).shape == (0, 2)
    assert rigid_edges(["a", "b"], np.full((5, 2, 3), np.nan)).shape == (0, 2)


def test_on_a_real_walk_every_marker_is_joined_and_no_hand_to_a_foot(data):
    from motionmend.io.c3d import read_c3d

    markers = read_c3d(data / "mocap" / "c3d" / "cmu_02_01.c3d")
    names = [name.rpartition(":")[2] for name in markers.names]
    pairs = [{names[a], names[b]} for a, b in rigid_edges(markers.names, markers.positions)]
    joined = set().union(*pairs)
    assert joined == set(names)
    assert {"LKNE", "LTHI"} in pairs or {"LKNE", "LSHN"} in pairs
    feet = {"LANK", "LHEE", "LTOE", "LMT5", "RANK", "RHEE", "RTOE", "RMT5"}
    hands = {"LFIN", "LWRA", "LWRB", "RFIN", "RWRA", "RWRB"}
    assert not any(pair & feet and pair & hands for pair in pairs)
