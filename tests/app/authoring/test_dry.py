"""Dry runs: which node runs after which outcome, without a robot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from command_line import call

ROOT = Path(__file__).parents[3]
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


def test_outcomes_are_taken_in_turn_and_the_last_repeats(dry):
    code, out, _ = dry(PICK, "--outcome", "grasp=failure,failure,success")
    assert (code, out.count("✗ grasp"), out.count("✔ grasp")) == (0, 2, 1)
    assert "attempt 3 of 3" in out
    code, out, _ = dry(PICK, "--outcome", "grasp=failure")
    assert (code, out.count("✗ grasp")) == (1, 3)
    last = out.splitlines()[-1]
    assert last.startswith("pick, dry: failure")
    assert last.endswith("(in grasp)")
    code, out, _ = dry(PICK, "--outcome", "grasp=failure", "-p", "tries=1")
    assert (code, out.count("✗ grasp")) == (1, 1)
    assert dry(PICK)[0] == 0


TWO = "task: t\ntree:\n  fallback:\n    - {name: left, open_gripper: }\n    - open_gripper\n"
OTHER = "task: t\ntree: {subtree: {file: other.yaml}}\n"
HALTED = "fallback: [{while: arm_healthy, wait: {duration_s: 9}}, {say: {text: given up}}]"
EVALUATED = """\
task: t
params: {n: {default: 3}}
regions: {table: {centre: [0, 0, 0], size: [1, 1, 1]}}
tree:
  sequence:
    - set: {k: 2}
    - wait: {duration_s: 1.5}
    - scan_for_objects: {region: table, count: found}
    - say: {text: 'I see {value}', value: $found}
    - {name: enough, compare: {value: $found, least: $n}}
    - {name: two, compare: {value: $k, equals: 2}}
"""
CASES = [
    (TWO, "left=failure", 0, "✔ open_gripper"),
    (TWO, "open_gripper=failure", 1, "open_gripper: scripted"),
    (TWO, "open_gripper=failure --outcome left=success", 0, "✔ left"),
    (OTHER, "open_gripper=running --outcome arm_healthy=success,failure", 1, "(in arm_healthy)"),
    ("task: t\ntree: {timeout_s: 60, open_gripper: }\n", "open_gripper=running", 1,
     "60.0 s  ✗ timeout: not done within 60 s"),
    ("task: t\ntree: {forever: arm_healthy}\n", "arm_healthy=failure", 1,
     "no end: still running after 1000 ticks"),
    (f"task: t\ntree: {{{HALTED}}}\n", "arm_healthy=success,success,failure", 0,
     "0.2 s  ■ wait: halted"),
    *((EVALUATED, "wait=success --key found=3", 0, told)
      for told in ("say: I see 3", "enough (compare): 3 of at least 3")),
    (EVALUATED, "two=success --key found=3", 0, "1.5 s  ✔ wait: waited"),
    (EVALUATED, "wait=success --key found=2", 1, "(in enough"),
    (EVALUATED, "wait=success --key found=3 -p n=4", 1, "(in enough"),
    (EVALUATED, "enough=success --key found=2", 0, "✔ two (compare): it is 2"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "outcome", "code", "told"), CASES)
def test_what_a_dry_run_tells(tmp_path, dry, text, outcome, code, told):
    (tmp_path / "other.yaml").write_text(
        "task: other\ntree:\n  while: arm_healthy\n  open_gripper:\n"
    )
    ended, out, _ = dry(text, "--outcome", *outcome.split())
    assert (ended, out.count(told)) == (code, 1), out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--outcome grap=failure", "no leaf `grap`; did you mean `grasp`?"),
        ("--outcome grasp=fails", "`fails` is not an outcome; write `success`, `failure`"),
        ("-p trys=3", "no parameter `trys`"),
        ("--key fuond=3", "no leaf writes `fuond`"),
    ],
)
def test_a_wrong_option_is_one_line_that_helps(dry, options, said):
    code, out, err = dry(PICK, *options.split())
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err


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
    (tmp_path / "t.yaml").write_text(PICK)
    code = (
        "import sys\nfrom app.commands import app\n"
        f"app(['dry', {str(tmp_path / 't.yaml')!r}], standalone_mode=False)\n"
        "print(*sorted({'torch', 'rerun', 'hw.sim.sim_world'} & set(sys.modules)), sep=',')\n"
    )
    done = subprocess.check_output([sys.executable, "-c", code], text=True, cwd=ROOT)
    assert done.splitlines()[-1] == ""
