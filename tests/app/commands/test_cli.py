"""The command line as a person meets it: its answers, its mistakes, its exit codes."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from rerun.chunk import RrdReader

from robots.load import SHIPPED

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


def test_a_run_leaves_summary_commands_recording_and_what_was_run(tmp_path, task):
    tree = task("navigate: {to: near}")
    code, out, _ = run(tmp_path, tree, "--seed", 4, "--json")
    (folder,) = (tmp_path / "runs").iterdir()
    summary = json.loads(out)
    assert summary == json.loads((folder / "summary.json").read_text())
    assert (code, summary["outcome"], summary["reason"]) == (0, "success", "navigate: at near")
    assert summary["limit_violations"] == 0
    assert (folder / "task.yaml").read_text() == tree.read_text()
    assert json.loads((folder / "options.json").read_text())["seed"] == 4
    commands = np.load(folder / "commands.npy")
    assert commands.shape == (summary["ticks"], 11)
    assert np.abs(commands[-1, 1:]).max() < 1e-3
    assert RrdReader(folder / "recording.rrd").recordings()


def test_the_summary_for_people_says_what_happened(tmp_path, task):
    code, out, _ = run(tmp_path, task("drive: {forward_m: 0.2}"), "--robot", "omni")
    assert code == 0
    assert out.startswith("✔ toy succeeded after ")
    assert "next: frankie-task view" in out
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name in out.replace("\n", "")
    assert json.loads((folder / "summary.json").read_text())["robot"] == "omni"


def test_a_task_that_fails_ends_with_1_and_names_the_node(tmp_path, task):
    code, out, _ = run(tmp_path, task("navigate: {to: far, timeout_s: 0.3}"), "--json")
    summary = json.loads(out)
    assert (code, summary["outcome"], summary["node"]) == (1, "failure", "navigate")
    assert summary["reason"].startswith("not at far after 0.3 s")


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
        ("--scene attic", "household"),
        ("--robot frankee", "did you mean `frankie`"),
        ("--world kinematics", "did you mean `kinematic`"),
        ("--weights no/such/weights.safetensors", "no/such/weights.safetensors"),
        ("-p attempts", "key=value"),
        ("-p tries=3", "`tries`"),
        (f"--record {__file__}", "--record"),
    ],
)
def test_a_wrong_option_is_one_line_that_helps(tmp_path, task, options, said):
    code, _, err = run(tmp_path, task("navigate: {to: near}"), *options.split())
    assert (code, err.count("\n")) == (2, 1)
    assert said in err
    assert not (tmp_path / "runs").exists()


def test_a_real_robot_must_be_armed_and_one_that_is_not_there_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    file = tmp_path / "ours.yaml"
    text = (SHIPPED / "frankie_site.yaml").read_text()
    file.write_text(text.replace("10.10.10.10", "127.9.9.9").replace("172.16.0.2", "127.9.9.9"))
    code, _, err = run(tmp_path, "pick_one", "--robot", file)
    assert (code, err.splitlines()[-1].count("--arm-the-robot")) == (2, 1)
    assert not (tmp_path / "runs").exists()
    code, _, err = call("run", "pick_one", "--robot", file, "--arm-the-robot", "--record", tmp_path)
    assert (code, "127.9.9.9" in err) == (3, True)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("draw", "draw: TREE is missing: A task file, or the name of a shipped task.\n"),
        ("robot import", "import: URDF is missing: A URDF, or a .xacro file.\n"),
        ("ask x", "ask: --model is missing: Its name at the endpoint.\n"),
    ],
)
def test_what_is_left_out_is_named_with_its_meaning(words, said):
    code, out, err = call(*words.split())
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.endswith(said)
