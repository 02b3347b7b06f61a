"""`explain --time`: where the seconds of a run went, on runs whose seconds are known."""

import numpy as np
import pytest
from command_line import call

from app.core import STATES, RunOptions, run_task
from app.live import View, ViewOptions
from app.review import DamagedRunError, Reason, time_use

HEAD = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
  far: {base: [0.0, -4.0], heading_deg: -90}
tree:
"""


@pytest.fixture
def ran(tmp_path):
    """Run a tree and return its folder."""

    def run(tree: str):
        path = tmp_path / "toy.yaml"
        path.write_text(HEAD + tree)
        options = RunOptions(
            tree=path,
            scene="single",
            record=tmp_path / "runs",
            view=ViewOptions(view=View.NONE),
            recording=False,
        )
        return run_task(options).folder

    return run


def test_a_wait_is_time_in_which_the_robot_is_still(ran):
    use = time_use(ran("  sequence: [{wait: {duration_s: 2.0}}, {navigate: {to: near}}]\n"))
    wait, navigate = use.typical.nodes
    assert wait.name.startswith("wait: ")
    assert navigate.name.startswith("navigate: ")
    assert wait.seconds == pytest.approx(2.0, abs=0.05)
    assert wait.waiting == pytest.approx(wait.seconds)
    assert wait.reasons == {Reason.WAITS.value: pytest.approx(wait.seconds)}
    assert navigate.waiting < 0.1
    assert navigate.arm > 0.5
    whole = use.typical.rest
    assert sum(whole.reasons.values()) == pytest.approx(whole.seconds)
    assert len(use.motion.reasons) == len(use.motion.times)


@pytest.mark.slow
def test_a_long_drive_is_limited_by_the_speed_of_the_base(ran):
    use = time_use(ran("  navigate: {to: far}\n"))
    (navigate,) = use.typical.nodes
    assert max(navigate.reasons, key=lambda reason: navigate.reasons[reason]) == Reason.DRIVE.value
    assert use.motion.distance == pytest.approx(4.0, abs=0.3)
    assert navigate.arm < 0.1


def test_the_command_prints_a_row_for_every_node(ran, tmp_path):
    ran("  sequence: [{wait: {duration_s: 1.0}}, {navigate: {to: near}}]\n")
    code, out, _ = call("explain", "--time", "--runs", tmp_path / "runs")
    assert code == 0
    rows = [line.split()[0] for line in out.splitlines() if line.startswith("  ")]
    assert rows[:4] == ["node", "wait:", "navigate:", "all"]
    assert "still: looks, thinks or rests 100 %" in out


def test_a_run_whose_motion_is_damaged_is_refused(ran):
    folder = ran("  wait: {duration_s: 0.5}\n")
    np.save(folder / STATES, np.zeros((4, 3)))
    with pytest.raises(DamagedRunError, match="cannot be read"):
        time_use(folder)
    (folder / STATES).unlink()
    with pytest.raises(DamagedRunError):
        time_use(folder)
