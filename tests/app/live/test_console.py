"""The options of `run` for control, and what happens when they are wrong."""

import json
import signal
import socket
import subprocess
import sys
from dataclasses import replace

import pytest
from harness import Harness
from sample_run import snapshot
from typer.testing import CliRunner

from app.commands import app
from app.live.console import ControlOptions, OperatorConsole
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


def test_the_page_stays_after_the_run_until_ctrl_c_and_closes_its_ports(tmp_path, task):
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    command = ["run", task, "--record", tmp_path / "runs", "--view", "none"]
    with subprocess.Popen(
        [
            sys.executable,
            "-m",
            "frankie_task_cli",
            *map(str, command),
            "--control",
            "--control-port",
            str(port),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None
        said = []
        for line in process.stderr:
            said.append(line)
            if "the page stays" in line:
                process.send_signal(signal.SIGINT)
    assert process.returncode == 0
    assert f"control at http://127.0.0.1:{port}/#" in "".join(said)
    with socket.create_server(("127.0.0.1", port)):
        pass
    (folder,) = (tmp_path / "runs").iterdir()
    options = json.loads((folder / "options.json").read_text())
    assert options["control"]["page_port"] == port


def test_a_stand_in_for_tests_acknowledges_a_released_emergency_stop_and_resumes(task):
    said: list[str] = []
    nodes = nodes_in_order(build(load(task), Harness().context))
    console = OperatorConsole(
        ControlOptions(acknowledge_after=0.5),
        task="toy",
        nodes=nodes,
        inject=lambda name: None,
        clear=lambda: None,
        viewer=None,
        say=said.append,
    )
    control, resumed = console.control, []
    for tick in range(300):
        if tick >= 100 and (control.state.emergency or tick < 200):
            control.emergency_stop("button pressed", pressed=tick < 200)
        seen = snapshot(tick)
        console.show(replace(seen, state=replace(seen.state, stamp=0.01 * tick)))
        if tick >= 100 and not control.state.paused:
            resumed.append(tick)
    assert control.attended
    assert resumed[0] == pytest.approx(252, abs=3)
    (told,) = said
    assert "acknowledge" in told
