"""Physical world: motors, held objects, collisions, determinism."""

import subprocess
import sys

import numpy as np
import pytest
from pinocchio import SE3
from solid_world import Solid, box, box_at_the_hand, cube, physical, turning

from hw import HardwareError, WorldError, WorldOptions, find_world, open_backend
from hw.sim import Walker
from robots import load_robot

pytest.importorskip("mujoco", reason="needs the extra `physics`")

FRANKIE = load_robot("frankie")
FRONT = FRANKIE.base.size[0] / 2.0


def between_the_fingers(mass: float = 0.3) -> Solid:
    pillar, thing = box_at_the_hand(mass)
    return physical(pillar, objects=[thing])


def lifted(mass: float = 0.3, force: float = 20.0) -> Solid:
    """The box in the hand, 0.15 m above the pillar."""
    sim = between_the_fingers(mass)
    sim.robot.grip(0.0, force)
    sim.drive(s=0.8)
    sim.rise()
    sim.drive(s=0.5)
    return sim


def in_hand(sim: Solid) -> SE3:
    return sim.body.wTe.actInv(sim.world.objects[0].pose)


def crept(sim: Solid, since: SE3) -> float:
    """[mm]."""
    return 1000.0 * float(np.linalg.norm(in_hand(sim).translation - since.translation))


def test_a_box_of_300_g_stays_where_it_is_held():
    sim = lifted()
    assert sim.world.supports() == {"box": "hand"}
    before = in_hand(sim)
    sim.drive(s=10.0)
    assert crept(sim, before) <= 0.5
    sim.drive((0.0, 0.0, 0.5), s=0.5)
    sim.drive((0.0, 0.0, 1.0), s=0.5)
    before = in_hand(sim)
    sim.drive((0.0, 0.0, 1.0), s=2.0)
    assert crept(sim, before) / 2.0 <= 0.5


def test_the_fingers_press_with_the_force_that_was_asked_for():
    sim = between_the_fingers()
    sim.robot.grip(0.0, 12.0)
    sim.drive(s=1.0)
    state = sim.robot.read()
    assert state.gripper_width == pytest.approx(0.04, abs=5e-4)
    assert not state.gripper_moving
    for side in ("left", "right"):
        presses = [one for one in sim.body.engine.presses(None) if one.side == side]
        assert sum(one.force for one in presses) == pytest.approx(12.0, abs=1.5)


def test_a_held_object_is_released_or_taken_out_of_the_hand():
    sim = lifted()
    high = sim.world.objects[0].pose.translation[2]
    sim.world.put("box", SE3(np.eye(3), np.array([-8.0, -8.0, 0.5])))
    sim.drive(s=0.3)
    assert sim.world.supports() == {"box": "floor"}
    assert sim.world.held is None
    sim.world.put("box", SE3(np.eye(3), np.array([2.0, 1.0, 0.5])))
    sim.drive(s=0.5)
    np.testing.assert_allclose(sim.world.objects[0].pose.translation, [2.0, 1.0, 0.03], atol=2e-3)
    assert sim.world.supports() == {"box": "floor"}
    sim = lifted()
    sim.robot.grip(0.08, 20.0)
    sim.drive(s=0.6)
    assert sim.world.held is None
    assert sim.world.supports() == {"box": "pillar"}
    assert sim.world.objects[0].pose.translation[2] < high - 0.1


def test_a_joint_follows_its_velocity_with_its_lag():
    sim = physical()
    sim.drive(qd=turning(6, 0.4), s=FRANKIE.arm.lag)
    assert 0.5 < sim.robot.read().qd[5] / 0.4 < 0.75
    sim.drive(qd=turning(6, 0.4), s=0.5)
    assert sim.robot.read().qd[5] == pytest.approx(0.4, rel=0.01)
    sim.drive(qd=turning(7, 2.61), s=0.6)
    assert sim.robot.read().qd[6] == pytest.approx(2.61, rel=0.01)


def test_the_bumper_stops_the_base_and_lets_it_leave():
    sim = physical(box("step", (1.0, 0.0, 0.15), (0.1, 1.0, 0.15)))
    assert sim.drive((0.5, 0.0, 0.0), s=2.0) == [("bumper", "the base hit step")]
    assert sim.x + FRONT == pytest.approx(0.9, abs=5e-3)
    assert sim.touches == ["the base hit step"]
    assert abs(sim.robot.read().faults[0].bearing) < 0.8
    sim.robot.recover()
    assert sim.drive((-0.3, 0.0, 0.0), s=1.0) == []
    assert sim.x + FRONT < 0.75


def test_the_reflex_stops_the_arm_at_30_newtons_and_lets_it_leave():
    x, y, z = Solid().link(7)
    sim = physical(box("post", (x, y + 0.15, z), (0.2, 0.05, 0.05)))
    ((kind, text),) = sim.drive(qd=turning(1, 0.2), s=2.0)
    who, newtons = text.split(" with ")
    assert kind == "reflex"
    assert who.endswith("hit post")
    assert 30.0 <= float(newtons.removesuffix(" N")) < 60.0
    before = sim.robot.read().q[0]
    sim.robot.recover()
    assert sim.drive(qd=turning(1, -0.2), s=1.0) == []
    assert sim.robot.read().q[0] < before - 0.15


def test_a_walker_that_runs_into_the_base_trips_the_bumper():
    walker = Walker("Rex", 0.25, 0.4, [(1.5, 0.0), (0.0, 0.0)], 1.0)
    sim = physical(walkers=[walker])
    assert sim.drive(s=1.5) == [("bumper", "the base hit Rex")]
    here = walker.pose.translation.copy()
    walker.move_to(sim.clock.now())
    np.testing.assert_array_equal(here, walker.pose.translation)


def test_a_diverged_simulation_is_a_hardware_error(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sim = physical(objects=[cube("cube", (1.5, 0.0, 0.02))])
    sim.drive(s=0.1)
    sim.body.engine.push_object(0, np.array([1.5, 0.0]), np.array([1e15, 0.0]))
    with pytest.raises(HardwareError, match="cannot be computed"):
        sim.drive(s=0.1)
    assert list(tmp_path.iterdir()) == []  # MuJoCo leaves no log


RUN = """
import hashlib
import numpy as np
from controller import Command
from hw import WorldOptions, open_backend
backend = open_backend("frankie", "physics", WorldOptions(scene="household", seed=3))
robot, states = backend.robot, hashlib.sha256()
for tick in range(150):
    state = robot.read()
    states.update(state.q.tobytes() + state.qd.tobytes() + state.oTb.homogeneous.tobytes())
    robot.send(Command(base_twist=np.array([1.0, 0.0, 0.3]), qd=np.full(7, 0.1)))
    if tick == 50:
        robot.grip(0.0, 20.0)
        backend.truth.put(backend.truth.objects[0].name, backend.truth.objects[1].pose)
    backend.clock.sleep_until(0.01 * (tick + 1))
for one in backend.truth.objects:
    states.update(one.pose.homogeneous.tobytes())
print(states.hexdigest())
"""


@pytest.mark.slow
def test_the_same_seed_goes_through_the_same_states_in_two_processes():
    run = (sys.executable, "-c", RUN)
    first, second = (subprocess.check_output(run, text=True) for _ in range(2))
    assert first == second


def test_without_the_extra_the_world_says_what_to_install(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("extensions.physics")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(WorldError, match=r'pip install "frankie-task\[physics\]"'):
        open_backend("frankie", "physics", WorldOptions(scene="single"))


def test_physics_of_another_engine_is_refused_in_one_line(monkeypatch):
    import mujoco

    monkeypatch.setattr(mujoco, "__version__", "3.17.0")
    with pytest.raises(WorldError, match=r"3\.17\.0 of mujoco-core 4\.0\.\d") as refused:
        find_world("physics").body()
    assert "\n" not in str(refused.value)
