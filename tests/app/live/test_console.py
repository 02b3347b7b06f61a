"""The options of `run` for control, and what happens when they are wrong."""

import json
import socket
import sys
from dataclasses import replace

import pytest
from harness import looking_down
from sample_run import snapshot
from typer.testing import CliRunner

from app.commands import app
from app.core.setup import VisionForm, open_setup
from app.live.console import ControlOptions, OperatorConsole
from controller import PoseGoal
from hw import FaultKind, WorldOptions
from perception import GraspDetector
from robots import load_robot
from trees.language import build, load, nodes_in_order

TREE = """\
task: toy
tree:
  sequence:
    - name: first
      wait: {duration_s: 0.05}
    - name: second
      wait: {duration_s: 0.05}
"""


@pytest.fixture
def task(tmp_path):
    path = tmp_path / "toy.yaml"
    path.write_text(TREE)
    return path


def run(tmp_path, task, *options: object) -> tuple[int, str]:
    arguments = ["run", task, "--record", tmp_path / "runs", "--view", "none", *options]
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--break", "secund", "--control"], "did you mean `second`"),
        (["--break", "second"], "--control"),
        (["--paused"], "--control"),
    ],
)
def test_bad_options_are_one_line_before_anything_is_made(tmp_path, task, options, message):
    code, err = run(tmp_path, task, *options)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("option", ["--control", "--groot2"])
def test_a_port_that_is_taken_is_reported_before_anything_is_made(tmp_path, task, option):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, err = run(tmp_path, task, option, f"{option}-port", port)
    assert code == 2
    assert str(port) in err
    assert f"{option}-port" in err
    assert not (tmp_path / "runs").exists()


def test_a_missing_extra_is_named(tmp_path, task, monkeypatch):
    monkeypatch.setitem(sys.modules, "zmq", None)
    code, err = run(tmp_path, task, "--groot2")
    assert code == 2
    assert 'pip install "frankie-task[groot]"' in err


def test_a_run_with_the_page_ends_by_itself_and_closes_its_ports(tmp_path, task):
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    code, err = run(tmp_path, task, "--control", "--control-port", port)
    assert code == 0
    assert f"control at http://127.0.0.1:{port}/#" in err
    with socket.create_server(("127.0.0.1", port)):
        pass
    (folder,) = (tmp_path / "runs").iterdir()
    options = json.loads((folder / "options.json").read_text())
    assert options["control"]["page_port"] == port


def test_an_emergency_stop_that_is_cleared_lets_the_robot_move_again(task):
    """The gate latches it; it opens on the loop, once no reading has the fault."""
    world = WorldOptions(scene="single")
    detector = GraspDetector(gripper=load_robot("frankie").gripper)
    with open_setup("frankie", "kinematic", world, detector, VisionForm.STEP) as setup:
        _press_and_release(setup, task)


def _press_and_release(setup, task):
    nodes = nodes_in_order(build(load(task), setup.context))
    console = OperatorConsole(
        ControlOptions(),
        task="toy",
        nodes=nodes,
        inject=setup.robot.inject,
        clear=setup.robot.clear,
        release=setup.gate.release,
        viewer=None,
        say=lambda text: None,
    )
    goal, number, moved = PoseGoal(wTe=looking_down(3.0, 0.5, 0.8)), 0, []

    def ticks(count: int) -> None:
        nonlocal number
        for _ in range(count):
            state = setup.robot.read()
            command, _ = setup.controller.step(state, goal, setup.gate.applied)
            setup.gate.send(command, state, setup.clock.session.now())
            console.show(replace(snapshot(0), state=state), changed=False)
            number += 1
            setup.clock.session.sleep_until(0.01 * number)
        moved.append(abs(state.base_twist).max())

    ticks(60)
    setup.robot.inject(FaultKind.EMERGENCY_STOP.value)
    ticks(100)
    console.clear()
    ticks(60)
    assert moved[0] > 0.1
    assert moved[1] < 1e-2
    assert moved[2] > 0.1
