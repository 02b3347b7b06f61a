"""The options of `run` for control, and what happens when they are wrong."""

import socket
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import call
from harness import Harness
from sample_run import snapshot

from app.live.operator_console import OperatorConsole
from app.run_options import RunOptions
from trees.language import build, load, nodes_in_order

TREE = """\
task: toy
scene: single
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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--break", "secund"], "did you mean `second`"),
        (["--break", "second"], "--with page"),
        (["--with", "pages"], "no observer is called `pages`"),
        (["--view", "web", "--view-address"], "in use; choose another port"),
        (["--web-port", "9090"], "--web-port is not an option any more; write --view-address"),
    ],
)
def test_bad_options_are_one_line_before_anything_is_made(tmp_path, task, options, message):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        if options[-1].endswith("-address"):
            options = [*options, f"127.0.0.1:{taken.getsockname()[1]}"]
        code, _, err = call("run", task, "--record", tmp_path / "runs", "--view", "none", *options)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "runs").exists()


def test_a_stand_in_for_tests_acknowledges_a_released_emergency_stop_and_resumes(task):
    said: list[str] = []
    nodes = nodes_in_order(build(load(task), Harness().context))
    console = OperatorConsole(
        RunOptions(tree=Path(), acknowledge_after=0.5), nodes, watched=False, say=said.append
    )
    console.attend(())
    control, resumed = console.control, []
    for tick in range(300):
        if tick >= 100 and (control.state.emergency or tick < 200):
            control.emergency_stop("button pressed", pressed=tick < 200)
        seen = snapshot(tick)
        seen = replace(seen, state=replace(seen.state, stamp=0.01 * tick))
        console.show(seen)
        if tick >= 100 and not control.state.paused:
            resumed.append(tick)
    assert control.attended
    assert resumed[0] == pytest.approx(252, abs=3)
    (told,) = said
    assert "acknowledge" in told
