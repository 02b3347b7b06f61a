"""Dry runs: which node runs after which outcome, without a robot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from command_line import call

PICK = """\
task: pick
params: {tries: {default: 3}}
regions: {table: {centre: [0, 0, 0], size: [1, 1, 1]}}
tree:
  sequence:
    - name: get it
      retry: $tries
      sequence:
        - open_gripper
        - grasp: {within: table}
    - place: {on: table}
"""


@pytest.fixture
def dry(tmp_path):
    """Runs a task file dry."""

    def run(text: str, *options: object) -> tuple[int, str, str]:
        path = tmp_path / "t.yaml"
        path.write_text(text, encoding="utf-8")
        return call("dry", path, *options)

    return run


def leaves(out: str) -> list[str]:
    """What the leaves came to, from the lines for people."""
    lines = [line[12:].split(": ")[0] for line in out.splitlines()[:-1]]
    return [line for line in lines if "(" not in line and "retry" not in line]


def test_outcomes_are_taken_in_turn_and_the_last_repeats(dry):
    code, out, _ = dry(PICK, "--outcome", "grasp=failure,failure,success")
    assert code == 0
    grasps = [line for line in leaves(out) if "grasp" in line]
    assert grasps == ["✗ grasp", "✗ grasp", "✔ grasp"]
    assert "attempt 3 of 3" in out
    code, out, _ = dry(PICK)
    assert (code, leaves(out)) == (0, ["✔ open_gripper", "✔ grasp", "✔ place"])
    code, out, _ = dry(PICK, "--outcome", "grasp=failure", "-p", "tries=1")
    assert (code, leaves(out).count("✗ grasp")) == (1, 1)
    code, out, _ = dry(PICK, "--outcome", "grasp=failure")
    assert code == 1
    assert [line for line in leaves(out) if "grasp" in line] == ["✗ grasp"] * 3
    last = out.splitlines()[-1]
    assert last.startswith("pick, dry: failure")
    assert last.endswith("(in grasp)")


def test_a_node_is_told_by_its_name_or_its_key(dry):
    text = "task: t\ntree:\n  fallback:\n    - {name: left, open_gripper: }\n    - open_gripper\n"
    code, out, _ = dry(text, "--outcome", "left=failure")
    assert (code, "✔ open_gripper" in out) == (0, True)
    code, out, _ = dry(text, "--outcome", "open_gripper=failure", "--outcome", "left=success")
    assert (code, "open_gripper: scripted" in out) == (0, False)
    code, _, _ = dry(text, "--outcome", "open_gripper=failure")
    assert code == 1


def test_guards_and_leaves_of_other_files_are_told_too(tmp_path, dry):
    (tmp_path / "other.yaml").write_text(
        "task: other\ntree:\n  while: arm_healthy\n  open_gripper:\n"
    )
    text = "task: t\ntree: {subtree: {file: other.yaml}}\n"
    assert dry(text)[0] == 0
    code, out, _ = dry(
        text, "--outcome", "open_gripper=running", "--outcome", "arm_healthy=success,failure"
    )
    assert code == 1
    assert "(in arm_healthy)" in out


def test_a_leaf_that_never_ends_meets_its_timeout_in_simulated_time(dry):
    text = "task: t\ntree: {timeout_s: 60, open_gripper: }\n"
    code, out, _ = dry(text, "--outcome", "open_gripper=running")
    assert code == 1
    assert "not done within 60 s" in out
    assert out.splitlines()[-2].split()[0] == "60.0"


def test_a_tree_that_never_ends_is_given_up_and_said_so(dry):
    text = "task: t\ntree: {forever: arm_healthy}\n"
    code, out, _ = dry(text, "--outcome", "arm_healthy=failure")
    assert code == 1
    assert "more lines" in out
    assert "no end: still running after 1000 ticks" in out.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--outcome", "grap=failure"], "no leaf `grap`; did you mean `grasp`?"),
        (["--outcome", "grasp=fails"], "`fails` is not an outcome; write `success`, `failure`"),
        (["-p", "trys=3"], "no parameter `trys`"),
        (["--key", "fuond=3"], "no leaf writes `fuond`"),
    ],
)
def test_a_wrong_option_is_one_line_that_helps(dry, options, said):
    code, out, err = dry(PICK, *options)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_what_needs_no_robot_is_evaluated(dry):
    text = (
        "task: t\nparams: {n: {default: 3}}\n"
        "regions: {table: {centre: [0, 0, 0], size: [1, 1, 1]}}\n"
        "tree:\n  sequence:\n"
        "    - set: {k: 2}\n"
        "    - wait: {duration_s: 1.5}\n"
        "    - scan_for_objects: {region: table, count: found}\n"
        "    - say: {text: 'I see {value}', value: $found}\n"
        "    - at_least: {value: $found, least: $n}\n"
        "    - equals: {value: $k, to: 2}\n"
    )
    code, out, _ = dry(text, "--key", "found=3")
    assert code == 0
    assert "1.5 s  ✔ wait: waited" in out
    assert "say: I see 3" in out
    assert "at_least: 3 of at least 3" in out
    code, out, _ = dry(text, "--key", "found=2")
    assert (code, "(in at_least)" in out) == (1, True)
    assert dry(text, "--key", "found=3", "-p", "n=4")[0] == 1
    # What is scripted is not evaluated.
    assert dry(text, "--key", "found=2", "--outcome", "at_least=success")[0] == 0


def test_halts_are_shown(dry):
    text = (
        "task: t\ntree:\n  fallback:\n    - while: arm_healthy\n      wait: {duration_s: 9}\n"
        "    - say: {text: given up}\n"
    )
    code, out, _ = dry(text, "--outcome", "arm_healthy=success,success,failure")
    assert code == 0
    assert "0.2 s  ■ wait: halted" in out
    assert out.count("halted") == 1


def test_a_dry_run_starts_anew_when_the_task_is_saved(tmp_path, monkeypatch):
    path = tmp_path / "t.yaml"
    path.write_text("task: first\ntree: open_gripper\n")
    saves = ["task: second\ntree: {wait: {duration_s: soon}}\n", "task: third\ntree: recover\n"]

    def edit(self, until) -> None:
        if not saves:
            raise KeyboardInterrupt
        path.write_text(saves.pop(0))

    monkeypatch.setattr("hw.WallClock.sleep_until", edit)
    code, out, err = call("dry", path, "--watch")
    assert [line.split(",")[0] for line in out.splitlines() if "dry" in line] == ["first", "third"]
    assert "expected a number" in err
    assert code == 0


def test_neither_network_nor_recorder_is_loaded(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(PICK)
    code = (
        "import sys\nfrom app.commands import app\n"
        f"app(['dry', {str(path)!r}], standalone_mode=False)\n"
        "print(*sorted({'torch', 'rerun', 'hw.sim.world'} & set(sys.modules)), sep=',')\n"
    )
    root = Path(__file__).parents[3]
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == ""
