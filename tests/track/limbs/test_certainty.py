"""How far joints may be from a pose that the image denies."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.performer import BONES
from motionmend.track.limbs.certainty import NOBODYS, astray

SHARES = st.floats(0.0, 1.0)
SHOWN = np.full(len(BONES), 40.0)


@given(SHARES, SHARES, SHARES)
def test_the_more_is_explained_wrongly_the_less_sure(usual, one, other):
    nothing = np.zeros(len(BONES))
    less, more = (astray(SHOWN, nothing, wrong, usual) for wrong in sorted((one, other)))
    assert (more >= less).all()
    assert (less >= 0.0).all()


@given(SHARES)
def test_what_is_usual_excuses_little_of_the_body_but_not_a_third(usual):
    nothing = np.zeros(len(BONES))
    assert not astray(SHOWN, nothing, min(usual, NOBODYS), usual).any()
    assert (astray(SHOWN, nothing, 0.45, usual) > 0.1).all()
    np.testing.assert_array_equal(astray(SHOWN, nothing, usual, np.nan), astray(SHOWN, nothing, usual, usual))


def test_a_limb_that_is_not_there_is_in_doubt_alone():
    denied = np.where([bone.startswith("l_forearm") for bone in BONES], 60.0, 0.0)
    found = astray(np.where(denied > 0, 0.0, SHOWN), denied, 0.1, 0.1)
    assert 0 < np.count_nonzero(found) < 4
    assert found.max() > 0.2
