"""What the base tells, whatever the network does to it, and the driver as a part of a robot."""

import re
from pathlib import Path

import numpy as np
import pytest
from emulated import SPEED, connected, is_at_rest, repeating
from waiting import until

from config.planar import Pose2D
from drivers.omron import OmronBase
from drivers.omron.telemetry import POSE
from extensions.emulators.omron import OmronEmulator, Options, Unicycle

pytestmark = pytest.mark.realtime


def away(base: OmronBase, wheels: Unicycle) -> float:
    """Distance of the pose that is read from the true one [m]."""
    seen = base.read().oTb.translation[:2]
    return float(np.hypot(*(seen - wheels.pose()[:2])))


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(Options(seed=1, omit=frozenset(POSE)), id="no fine pose"),
        pytest.param(
            Options(seed=6, pieces=True, jitter=0.09, delay=0.02, garbage=True),
            id="a few bytes at a time, late, with damaged frames",
        ),
    ],
)
def test_the_base_drives_and_tells_where_it_is_under(options):
    wheels = Unicycle(Pose2D(1.0, -2.0, 3.0))
    with (
        OmronEmulator(options, wheels) as emulator,
        connected(emulator, lists_patience=0.3) as base,
    ):
        start = base.read()
        np.testing.assert_allclose(start.oTb.translation, (1.0, -2.0, 0.0), atol=2e-3)
        heading = np.arctan2(start.oTb.rotation[1, 0], start.oTb.rotation[0, 0])
        assert heading == pytest.approx(3.0, abs=1e-2)
        assert start.battery == pytest.approx(0.87)
        late = 0.05 + options.delay + options.jitter
        with repeating(lambda: base.send(np.array([SPEED, 0.0, -0.4]))):
            until(lambda: wheels.twist()[0] > 0.1)
            until(lambda: away(base, wheels) < 0.01 + 0.3 * late)
        base.stop()
        until(lambda: not base.read().twist.any())
        still = np.array([*wheels.pose()[:2], 0.0])
        until(lambda: np.abs(base.read().oTb.translation - still).max() < 2e-3)
        assert base.read().faults == ()


def test_what_is_applied_is_told():
    with OmronEmulator() as emulator, connected(emulator) as base:
        for wanted, applied in (
            ((0.1, 0.0, 0.0), (0.1, 0.0, 0.0)),
            ((0.02, 0.0, 0.01), (0.02, 0.0, 0.01)),
            ((0.2, 0.3, 0.1), (0.2, 0.0, 0.1)),  # it cannot move sideways
            ((2.0, 0.0, 0.4), (1.0, 0.0, 0.2)),  # slower along the same arc
            ((-0.5, 0.0, 0.0), (-0.25, 0.0, 0.0)),
            ((np.nan, 0.0, 0.0), (0.0, 0.0, 0.0)),
            ((0.0, 0.0, np.inf), (0.0, 0.0, 0.0)),
        ):
            np.testing.assert_allclose(base.send(np.array(wanted)), applied, atol=1e-9)


def test_the_first_contact_of_the_page_works_with_the_emulator(capsys):
    page = Path(__file__).parents[4] / "docs" / "hardware.md"
    code, *_ = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    with OmronEmulator() as emulator:
        for said, here in (
            ('address="10.10.10.10"', f'address="127.0.0.1", port={emulator.port}'),
            ('password="adept"', f'password="adept", port={emulator.arcl_port}'),
        ):
            assert said in code
            code = code.replace(said, here)
        exec(compile(code, str(page), "exec"), {})
        assert is_at_rest(emulator)
        assert emulator.controller.drive.pose()[0] > 0.01
    assert "double: trans" in capsys.readouterr().out
