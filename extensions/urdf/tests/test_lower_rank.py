"""Arms that cannot hold every pose alone: their base gives what they lack."""

from pathlib import Path

import numpy as np
import pytest
from command_line import call

from controller import RobotModel, dexterity
from lab.bench.configuration import Configuration
from lab.bench.goals import generate_goals
from lab.bench.reaching import Conditions, run_trials
from robots import load_robot

HERE = Path(__file__).parent


@pytest.fixture(scope="module", params=["mast", "lekiwi_like"])
def robot(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("robots") / request.param
    return request.param, out, call("robot", "import", HERE / f"{request.param}.urdf", "-o", out)[1]


def test_the_base_gives_what_the_arm_lacks(robot):
    """A telescope sideways is moved along x by its base; five joints aside by theirs."""
    name, out, told = robot
    found = dexterity(load_robot(out))
    assert found.rank == 6
    if name == "mast":
        assert "dexterity: of the arm and its base along x" in told
        assert found.bearing == pytest.approx(-np.pi / 2.0, abs=0.2)
        assert load_robot(out).arm.telescopes == (0, 1, 1, 3, 4, 5)
    else:
        assert "dexterity: of the arm and its base along y" in told
        assert found.bearing == 0.0


@pytest.mark.slow
def test_every_pose_of_its_own_postures_is_reached(robot):
    configuration = Configuration(robot=str(robot[1]), base_speed=1.0)
    goals = generate_goals(configuration.model(), 30, 4711)
    trials = run_trials(configuration, Conditions(), goals, lambda trial: None, workers=1)
    assert [k for k, one in enumerate(trials) if one.failure] == []
    assert sum(one.limit_violations + one.contact_samples for one in trials) == 0


def test_a_ready_posture_has_the_hand_at_the_bearing_that_it_prefers(robot):
    name, out, _ = robot
    description = load_robot(out)
    bTe = RobotModel(description).bTe(description.arm.ready)
    assert name != "mast" or bTe.rotation[2, 2] < -0.98
    x, y, _ = bTe.translation
    assert dexterity(description).bearing_of(x, y) == pytest.approx(0.0, abs=0.3)
