"""The examples of docs/extending.md, installed as packages and run."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import panda_environment
import pytest
from command_line import call

from frankie_task import load_robot

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "extending.md").read_text("utf-8")
ROBOSUITE = ROOT / "examples" / "robosuite_world"
COMMAND, OBSERVER, WORLD = re.findall(r"^```python\n(.*?)^```", PAGE, re.M | re.S)
TASK = "task: t\nposes:\n  near: {xyz: [0.9, 0.3, 0.7], rpy_deg: [180, 0, 0]}\n"


@pytest.fixture
def task(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(f"{TASK}tree:\n  navigate: {{to: near}}\n")
    return path


def test_a_command(install, task):
    install(COMMAND, "commands", "lengths", "lengths")
    assert call("lengths", task)[:2] == (0, "t: 5 lines\n")


def test_an_observer(install, task, tmp_path):
    install(OBSERVER, "observers", "log", "log")
    words = ("--scene", "single", "--view", "none", "--record", tmp_path / "runs")
    assert call("run", task, *words, "--with", f"log:{tmp_path / 'heights'}")[0] == 0
    heights = (tmp_path / "heights").read_text().splitlines()
    assert len(heights) > 100
    assert float(heights[-1]) == pytest.approx(0.7, abs=0.02)
    code, _, said = call("run", task, *words, "--with", "log")
    assert (code, said.splitlines()[-1]) == (2, "--with log: name a file, as log:heights.txt")


def test_a_world(install, task, tmp_path):
    install(WORLD, "worlds", "ideal", "ideal")
    words = ("--view", "none", "--record", tmp_path / "runs", "--json")
    code, _, said = call("run", task, "--world", "ideal", *words)
    assert code == 0, said
    (folder,) = (tmp_path / "runs").iterdir()
    assert call("replay", folder)[0] == 0
    assert "by itself" not in call("explain", folder)[1]


@pytest.mark.parametrize(
    ("group", "words"),
    [("worlds", ("--world", "broken")), ("observers", ("--with", "broken", "--view", "none"))],
)
def test_a_broken_package_is_told_with_its_line_and_hinders_only_who_asks(
    install, task, tmp_path, group, words
):
    install("\n\nraise RuntimeError('no')\n", group, "broken", "x")
    code, _, said = call("run", task, "--record", tmp_path / "runs", *words)
    assert code == 2
    assert re.search(r"`broken` of package_\d+ 1.0 cannot be used: RuntimeError: no \(.*:3\)", said)
    assert not (tmp_path / "runs").exists()
    others = ("--scene", "single", "--view", "none", "--record", tmp_path / "others")
    assert call("run", task, *others)[0] == 0


def test_a_broken_command_is_a_warning_in_help(install, task):
    install("import nothing_here\n", "commands", "broken", "x")
    code, out, said = call("--help")
    assert (code, "broken" in out) == (0, False)
    assert "warning: the command `broken`" in said
    assert call("broken")[0] == 2
    assert load_robot("frankie").name == "frankie"


@pytest.mark.slow
def test_a_world_of_others(tmp_path, monkeypatch):
    """The world of robosuite in the engine of its stand-in, whose robot is not ours."""
    home = tmp_path / "site"
    offline = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet")
    words = [sys.executable, "-m", "pip", "install", *offline, "--target", home, ROBOSUITE]
    subprocess.run(words, check=True)
    monkeypatch.syspath_prepend(str(home))
    monkeypatch.setitem(sys.modules, "robosuite", panda_environment)
    lift = (ROBOSUITE / "lift.yaml", "--map", ROBOSUITE / "table.yaml", "--view", "none")
    words = ("--record", tmp_path / "runs", "--robot", ROBOSUITE / "panda_omron.yaml", "--json")
    code, _, said = call("run", *lift, "--world", "robosuite:Lift", "--seed", "3", *words)
    assert (code, "judged by robosuite: success" in said) == (0, True), said
    code, _, said = call("run", *lift, "--world", "robosuite:Lif", *words)
    assert (code, "no task of robosuite is called `Lif`" in said) == (2, True)
