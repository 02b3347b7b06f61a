"""The doctor tells what is good, what is bad, and what nobody can know, without moving anything."""

import json

import numpy as np
import pytest
from command_line import call
from emulated_robot import emulated, needs_drivers, robot_file

from hw import WorldOptions, open_backend
from hw.hardware import Verdict, examine
from robots import load_real_robot
from robots.load import SHIPPED

PARTS = ("base", "arm", "gripper", "camera")


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    monkeypatch.setattr("hw.findings.LOOKS", 20)
    monkeypatch.setattr("hw.hardware.computer._NAPS", 50)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    path = robot_file(tmp_path_factory.mktemp("robots"))
    with emulated(path) as link:
        yield path, link


def found(path):
    """What is found of a robot: verdict and text of each, by what it is about."""
    findings = list(examine(load_real_robot(path)))
    return {
        about: [(one.verdict, one.text) for one in findings if one.about == about]
        for about in {one.about for one in findings}
    }


def said(findings, verdict):
    return " | ".join(text for has, text in findings if has is verdict)


@needs_drivers
def test_an_emulated_robot_is_good_and_has_not_moved(place):
    path, link = place
    before = link.do("arm tell")["q"]
    findings = found(path)
    for part in PARTS:
        bad = [text for verdict, text in findings[part] if verdict is Verdict.BAD]
        # Few and late, as on a computer that has other work.
        assert all("ms old" in text for text in bad), bad
    for words in (
        "ArNetworking 5MTX", "full_scale of the file is what the base tells",
        "odometry: of its encoders", "localisation score: 0.87", "points in the last one",
        "at rest that varies by 0.0 mm and 0.00 deg",
    ):  # fmt: skip
        assert words in said(findings["base"], Verdict.GOOD)
    assert "interface version 5" in said(findings["arm"], Verdict.GOOD)
    assert any("images/s, 0 lost" in text for _, text in findings["camera"])
    assert "hand-eye" in said(findings["calibration"], Verdict.OPEN)
    told = link.do("arm tell")
    np.testing.assert_allclose(told["q"], before, atol=1e-9)
    assert told["commands"] == 0


@needs_drivers
@pytest.mark.slow
def test_what_the_base_tells_of_itself_can_be_written_for_the_file(place):
    path, _ = place
    text, site = path.read_text(), path.with_name("site.yaml")
    _, out, _ = call("doctor", "--robot", path, "--write-site", site)
    assert "full_scale: " in out
    path.write_text(text.replace("    arcl:", "    full_scale: site.yaml\n    arcl:"))
    scale = load_real_robot(path).hardware.base.site
    path.write_text(text)
    assert (scale.forward, scale.turn_deg, scale.dead_translation) == (1.0, 50.0, 10.0)


@needs_drivers
def test_wrong_values_a_pressed_button_and_a_commander_are_named(place):
    path, link = place
    text = path.read_text()
    assert "    arcl: {password: adept}\n" in text, "else the line below does nothing"
    path.write_text(
        text.replace("    arcl:", "    full_scale: {forward: 0.7, turn_deg: 40}\n    arcl:")
    )
    link.do("stop")
    findings = found(path)
    told = said(findings["base"], Verdict.BAD)
    assert "write below full_scale: forward: 1, turn_deg: 50" in told
    assert "emergency stop" in told
    assert "release it" in said(findings["arm"], Verdict.BAD)
    link.do("release")
    path.write_text(text)
    backend = open_backend(str(path), "kinematic", WorldOptions(scene="single", seed=1))
    with backend.robot as robot:
        findings = found(path)
        assert backend.truth.base.isApprox(robot.read().oTb, 1e-3)
    assert "commanded by process" in said(findings["commander"], Verdict.BAD)
    assert not set(PARTS) & set(findings)


def test_a_robot_that_is_not_there_is_bad_in_every_part(tmp_path):
    path = tmp_path / "ours.yaml"
    text = (SHIPPED / "frankie_site.yaml").read_text()
    path.write_text(text.replace("10.10.10.10", "127.9.9.8").replace("172.16.0.2", "127.9.9.8"))
    code, out, _ = call("doctor", "--robot", path, "--json")
    assert code == 3
    findings = [json.loads(line) for line in out.splitlines()]
    for part in PARTS:
        assert any(one["about"] == part and one["verdict"] == "bad" for one in findings)


def test_a_described_robot_has_nothing_but_the_computer_to_look_at():
    _, out, _ = call("doctor", "--robot", "frankie")
    assert "described only" in out
    assert "real-time priority" in out
    assert "commander" not in out
