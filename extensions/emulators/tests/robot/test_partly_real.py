"""A robot of which some parts are simulated; of the others the arm is an emulated Panda."""

import numpy as np
import pytest
from emulated_panda import emulated, needs_library
from pinocchio import SE3

import frankie_task
from hw import SimClock
from hw.hardware.arming import prove
from hw.real_parts import parts_of
from robots import load_real_robot, load_robot

TASK = """\
task: reach
poses:
  there: {xyz: [1.2, 0.1, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence:
    - navigate: {to: there}
    - open_gripper
"""
PUSHED = """\
import numpy as np
from pinocchio import SE3
from frankie_task import BaseState, DriverContext, DriverOptions, PassivePart

class Pushed(PassivePart):
    oTb = SE3.Identity()
    def __init__(self, options: DriverOptions, context: DriverContext):
        self.clock = context.clock
    def read(self):
        return BaseState(stamp=self.clock.now(), oTb=self.oTb, twist=np.zeros(3))
"""


def written(folder, **real):
    """A robot file whose parts are simulated, but for some."""
    path = folder / "ours.yaml"
    parts = dict.fromkeys(("base", "arm", "gripper", "camera"), "simulated") | real
    lines = (f"  {kind}: {{driver: {driver}}}\n" for kind, driver in parts.items())
    path.write_text("robot: frankie\nhardware:\n  speed_percent: 100\n" + "".join(lines))
    return path


@pytest.mark.slow
@needs_library
@pytest.mark.realtime
def test_a_task_moves_a_real_arm_on_a_simulated_base(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    task = tmp_path / "task.yaml"
    task.write_text(TASK)
    with emulated() as panda:
        path = written(tmp_path, arm=f"panda, address: {panda.address}", gripper="franka_hand")
        with pytest.raises(frankie_task.UserError, match="--arm-the-robot"):
            frankie_task.run_task(task, robot=str(path))
        prove(load_real_robot(path))  # else it moves at 10 %
        before = panda.tell()["q"]
        ran = frankie_task.run_task(task, robot=str(path), armed=True, record=tmp_path / "runs")
        after = panda.tell()["q"]
    assert ran.summary.outcome == "success"
    states = np.load(ran.folder / "states.npy")
    assert states[-1, 1] - states[0, 1] > 0.2
    assert np.abs(np.subtract(after, before)).max() > 0.1
    np.testing.assert_allclose(after, states[-1, 7:14], atol=0.01)


def test_a_simulated_arm_is_where_a_real_base_is(tmp_path, install):
    install(PUSHED, "drivers", "base.pushed", "Pushed")
    path, clock = written(tmp_path, base="pushed"), SimClock()
    parts = parts_of(load_real_robot(path), load_robot(path), clock, scene="single")
    seen = parts["arm"].truth
    assert len(seen.objects) == 1
    for x in (0.0, 2.2):  # before the container
        parts["base"].oTb = SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        clock.sleep_until(clock.now() + 0.1)
        parts["arm"].read()
        assert seen.base.translation[0] == x


def test_a_simulated_laser_sees_what_is_on_the_map(tmp_path):
    post = "{name: post, centre: [2.0, 0.0, 0.5], size: [0.2, 0.2, 1.0]}"
    (tmp_path / "hall.yaml").write_text(f"fixtures:\n  - {post}\n")
    path = written(tmp_path, arm="panda, address: 127.0.0.9", gripper="franka_hand")
    path.write_text(f"{path.read_text()}map: hall.yaml\n")
    clock = SimClock()
    parts = parts_of(load_real_robot(path), load_robot(path), clock, scene="single")
    clock.sleep_until(0.3)
    scan = parts["laser"].latest()
    assert np.nanmin(scan.ranges) == pytest.approx(2.0 - 0.1 - 0.25, abs=0.05)
    assert parts["base"].truth is None


@pytest.mark.parametrize(
    ("real", "told"),
    [
        ({"gripper": "franka_hand"}, "a simulated arm needs a simulated gripper"),
        ({"arm": "panda, address: 10.0.0.2"}, "a simulated gripper needs a simulated arm"),
        ({"base": "ros2", "laser": "simulated"}, "a simulated laser needs a simulated base"),
    ],
)
def test_parts_that_cannot_be_one_robot_are_refused(tmp_path, real, told):
    with pytest.raises(frankie_task.UserError, match=told):
        load_real_robot(written(tmp_path, **real))
