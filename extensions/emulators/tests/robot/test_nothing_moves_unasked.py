"""Only a run homes a hand, and says so before; who looks or connects moves nothing."""

import pytest
from emulated_robot import emulated, needs_drivers, robot_file

from app.authoring.teach import Form, teach
from hw import FaultKind, HardwareError, WorldOptions, open_backend
from hw.hardware import Verdict, examine
from robots import load_real_robot

pytestmark = [pytest.mark.realtime, needs_drivers]


def opened(path, announce=None):
    options = WorldOptions(scene="household", seed=0, announce=announce)
    return open_backend(str(path), "kinematic", options).robot


def bad_of(path):
    """What is bad of each part, as the doctor finds."""
    findings = examine(load_real_robot(path))
    return {one.about: one.text for one in findings if one.verdict is Verdict.BAD}


@pytest.mark.slow
def test_a_hand_that_was_not_homed_is_homed_by_a_run_alone(tmp_path):
    path, places, said = robot_file(tmp_path), tmp_path / "places.yaml", []
    with emulated(path, "household", 0, "unhomed") as link:

        def say(text):
            assert link.do("arm tell")["homings"] == 0
            said.append(text)

        before = link.do("arm tell")["width"]
        assert "was not homed" in bad_of(path)["gripper"]
        where = {"robot": str(path), "world": "kinematic", "form": Form.ARM}
        teach("here", places, **where, replace=False, armed=True)
        assert "here" in places.read_text()
        link.do("arm guide")
        more = iter([True, True, False]).__next__
        teach("way", places, **where, replace=False, armed=True, more=more)
        assert places.read_text().count("    - {joints_deg") == 2
        link.do("arm release")
        with opened(path) as robot:
            (fault,) = robot.read().faults
            assert fault.kind is FaultKind.NOT_READY
        told = link.do("arm tell")
        assert (told["homings"], told["stops"], told["commands"]) == (0, 0, 0)
        assert told["width"] == before
        with opened(path, say) as robot:
            assert robot.read().faults == ()
            assert robot.read().gripper_width > 0.07
        assert len(said) == 1
        assert "close and open" in said[0]
        assert link.do("arm tell")["homings"] == 1
        link.do("arm blackout")
        link.do("arm hold")
        robot = opened(path, print)
        with pytest.raises(HardwareError, match="take that out"):
            robot.connect()
        robot.close()
        assert link.do("arm tell")["homings"] == 1
