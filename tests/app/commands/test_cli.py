"""The command line as a person meets it: its answers, its mistakes, its exit codes."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from rerun.chunk import RrdReader

TREE = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
  far: {xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}
regions:
  table: {centre: [0.0, 1.6, 0.6], size: [0.8, 0.36, 0.2]}
tree:
  sequence:
"""


@pytest.fixture
def task(tmp_path):
    """Writes a task file with these lines in its sequence."""

    def write(*lines: str) -> Path:
        path = tmp_path / "toy.yaml"
        path.write_text(TREE + "".join(f"    - {line}\n" for line in lines))
        return path

    return write


def run(tmp_path, tree, *options: object) -> tuple[int, str, str]:
    return call("run", tree, "--scene", "single", "--record", tmp_path / "runs", *options)


def the_folder(tmp_path) -> Path:
    (folder,) = (tmp_path / "runs").iterdir()
    return folder


# what a run leaves


def test_a_run_leaves_summary_commands_recording_and_what_was_run(tmp_path, task):
    tree = task("navigate: {to: near}")
    code, out, _ = run(tmp_path, tree, "--seed", 4, "--json")
    assert code == 0
    folder = the_folder(tmp_path)
    summary = json.loads(out)
    assert summary == json.loads((folder / "summary.json").read_text())
    assert summary["outcome"] == "success"
    assert summary["reason"] == "navigate: at near"
    assert summary["limit_violations"] == 0
    assert (folder / "task.yaml").read_text() == tree.read_text()
    assert json.loads((folder / "options.json").read_text())["seed"] == 4
    commands = np.load(folder / "commands.npy")
    assert commands.shape == (summary["ticks"], 11)
    assert not commands[-1, 1:].any() or np.abs(commands[-1, 1:]).max() < 1e-3
    reader = RrdReader(folder / "recording.rrd")
    assert reader.recordings()


def test_the_summary_for_people_says_what_happened(tmp_path, task):
    code, out, _ = run(tmp_path, task("drive: {forward_m: 0.2}"), "--robot", "omni")
    assert code == 0
    assert out.startswith("✔ toy succeeded after ")
    assert "next: frankie-task view" in out
    folder = the_folder(tmp_path)
    assert str(folder.name) in out.replace("\n", "")
    assert json.loads((folder / "summary.json").read_text())["robot"] == "omni"


def test_a_task_that_fails_ends_with_1_and_names_the_node(tmp_path, task):
    tree = task("navigate: {to: far, timeout_s: 0.3}")
    code, out, _ = run(tmp_path, tree, "--json")
    assert code == 1
    summary = json.loads(out)
    assert summary["outcome"] == "failure"
    assert summary["node"] == "navigate"
    assert summary["reason"].startswith("not at far after 0.3 s")


# bad input: one line with place and hint, exit code 2, nothing moved


def test_a_mistake_in_the_task_is_one_located_line(tmp_path, task):
    tree = task("navigat: {to: near}")
    code, out, err = run(tmp_path, tree)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"{tree}:9:7: ")
    assert "did you mean `navigate`" in err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--scene", "attic"), "household"),
        (("--robot", "frankee"), "did you mean `frankie`"),
        (("--world", "kinematics"), "did you mean `kinematic`"),
        (("--weights", "no/such/weights.safetensors"), "no/such/weights.safetensors"),
        (("-p", "attempts"), "key=value"),
        (("-p", "tries=3"), "`tries`"),
    ],
)
def test_a_wrong_option_is_one_line_that_helps(tmp_path, task, options, said):
    code, _, err = run(tmp_path, task("navigate: {to: near}"), *options)
    assert code == 2
    assert said in err
    assert err.count("\n") == 1
    assert not (tmp_path / "runs").exists()


def test_a_folder_that_cannot_be_written_is_said_before_anything_moves(tmp_path, task):
    (tmp_path / "file").write_text("")
    code, _, err = call("run", task("navigate: {to: near}"), "--record", tmp_path / "file")
    assert code == 2
    assert "--record" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("draw",), "draw: TREE is missing: A task file, or the name of a shipped task.\n"),
        (("robot", "import"), "import: URDF is missing: A URDF, or a .xacro file.\n"),
        (("ask", "x"), "ask: --model is missing: Its name at the endpoint.\n"),
    ],
)
def test_what_is_left_out_is_named_with_its_meaning(words, said):
    code, out, err = call(*words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.endswith(said)
