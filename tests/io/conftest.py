"""What tests of Acclaim's files ask for."""

import pytest
from acclaim_files import ASF


@pytest.fixture
def folder(tmp_path):
    """A folder that holds the small person's .asf."""
    (tmp_path / "small.asf").write_text(ASF)
    return tmp_path
