"""What the tests of the Panda's driver share."""

import pytest
from emulated_panda import Emulator


@pytest.fixture(scope="module")
def emulator():
    emulator = Emulator()
    yield emulator
    emulator.close()
