"""What tests of the tree language share."""

import pytest
from tree_toys import Run


@pytest.fixture
def run(tmp_path):
    """Makes a tree of toys from the text of its `tree:` section."""
    return lambda tree: Run(tmp_path, tree)
