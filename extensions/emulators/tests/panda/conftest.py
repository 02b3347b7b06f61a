"""What the tests of the Panda's driver share."""

import pytest
from emulated_panda import emulated


@pytest.fixture(scope="module")
def emulator():
    with emulated() as emulator:
        yield emulator
