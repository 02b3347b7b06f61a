"""Only a run homes a hand, and says so before; who looks or connects moves nothing."""

from __future__ import annotations

import pytest
from emulated_robot import emulated, needs_drivers, robot_file

from app.authoring.teach import Form, teach
from hw import FaultKind, HardwareError, WorldOptions, open_backend
from hw.hardware import Verdict, examine
from robots import load_real_robot

pytestmark = needs_drivers


@pytest.fixture
def unhomed(tmp_path):
    path = robot_file(tmp_path)
    with emulated(path, "household", 0, "unhomed") as link:
        yield path, link


def about(path, part):
    return [one for one in examine(load_real_robot(path)) if one.about == part]


def test_doctor_and_teach_tell_of_a_hand_that_was_not_homed_and_leave_it(unhomed, tmp_path):
    path, link = unhomed
    before = link.do("arm tell")["width"]
    bad = [one.text for one in about(path, "hand") if one.verdict is Verdict.BAD]
    assert any("was not homed" in text for text in bad)
    places = tmp_path / "places.yaml"
    teach(
        "here",
        places,
        robot=str(path),
        world="kinematic",
        form=Form.ARM,
        replace=False,
        armed=True,
    )
    assert "here" in places.read_text()
    told = link.do("arm tell")
    assert (told["homings"], told["stops"], told["commands"]) == (0, 0, 0)
    assert told["width"] == before


def test_a_run_announces_homing_and_then_does_it(unhomed):
    path, link = unhomed
    said = []

    def say(text):
        assert link.do("arm tell")["homings"] == 0
        said.append(text)

    options = WorldOptions(scene="household", seed=0, announce=say)
    with open_backend(str(path), "kinematic", options).robot as robot:
        assert robot.read().faults == ()
        assert robot.read().gripper_width > 0.07
    assert len(said) == 1
    assert "close and open" in said[0]
    assert link.do("arm tell")["homings"] == 1


def test_what_the_hand_may_hold_is_not_dropped_by_homing(unhomed):
    path, link = unhomed
    options = WorldOptions(scene="household", seed=0)
    with open_backend(str(path), "kinematic", options).robot as robot:
        (fault,) = robot.read().faults
        assert fault.kind is FaultKind.NOT_READY
    link.do("arm hold")
    options = WorldOptions(scene="household", seed=0, announce=print)
    robot = open_backend(str(path), "kinematic", options).robot
    with pytest.raises(HardwareError, match="take that out"):
        robot.connect()
    robot.close()
    assert link.do("arm tell")["homings"] == 0


@pytest.mark.slow
def test_a_firewall_is_told_and_nothing_good_beside_it(tmp_path):
    path = robot_file(tmp_path)
    with emulated(path, "single", 1, "udp-blocked"):
        for part in ("arm", "hand"):
            (finding,) = about(path, part)
            assert finding.verdict is Verdict.BAD
            assert "firewall" in finding.text
