"""README and docs: every console line and code block is run here, or NOT_HERE says why not.

docs/authoring.md is run as a whole, by tests/app/authoring/test_authoring_guide.py, and
docs/control_library.md by tests/test_control_library.py.
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
from itertools import product
from pathlib import Path
from textwrap import indent

import numpy as np
import pytest
from command_line import call
from example_robots import EXAMPLES
from test_documents import PAGES, ROOT, parse

from app.core import RunOptions, run_task
from hw.sim import LEVELS, load_fixtures, load_localisation
from robots import half_extents
from trees.language import load

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"^```yaml\n# (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)

WHOLE = ("authoring.md", "control_library.md")

NOT_HERE = {
    # Beginnings of console lines.
    "make run": "it installs 2.5 GB",
    ". .venv/bin/activate": "of the shell",
    "export OPENAI_API_KEY": "of the shell",
    "frankie-task ask": "needs a network; extensions/agent/tests has a scripted model",
    "frankie-task bench": "takes minutes to hours; tests/lab/bench runs small ones",
    "frankie-task calibrate base-arm": "needs hardware",
    "frankie-task calibrate hand-eye --robot": "needs hardware",
    "frankie-task emulate": "runs until Ctrl-C; extensions/emulators/tests ends it",
    "frankie-task film": "needs a Vulkan driver; tests/lab/film/test_film.py",
    "frankie-task grasp eval": "takes minutes to hours",
    "frankie-task grasp fit": "needs outcomes, which takes minutes to hours",
    "frankie-task grasp outcomes": "takes minutes to hours",
    "frankie-task grasp probability": "needs those outcomes",
    "frankie-task grasp show": "needs your images; tests/lab/grasps/test_grasp_show.py has some",
    "frankie-task grasp train": "takes hours",
    "frankie-task robot show": "needs a screen",
    "frankie-task run pick_place": "takes minutes; tests/app/core/test_shipped_tasks.py",
    "frankie-task serve": "runs until Ctrl-C; extensions/page/tests ends it",
    "frankie-task view": "needs a screen or a browser; tests/app/live/test_viewer.py",
    "pytest": "is a test",
    # Blocks of a kind in a page, or those that begin so.
    "architecture.md mermaid": "a picture",
    "controller.md mermaid": "a picture",
    "control.md ": "what a command prints",
    "perception.md ": "a picture",
    "drivers.md yaml": "a part of a file; tests/test_driver_package.py has the whole",
    "extending.md toml": "a part of a file; tests/test_extending.py installs what it names",
    "hardware.md python": "needs hardware; its imports are tested in tests/test_documents.py",
    "hardware.md yaml": "needs an arm; extensions/emulators/tests/robot/test_partly_real.py",
    "language.md yaml - subtree:": "the file is yours; tests/trees/test_subtrees.py",
    "scenes.md yaml objects:": "the meshes are yours; tests/hw/sim has some",
}
SLOW = (
    "run ",
    "calibrate hand-eye --simulate",
    "robot ",
    "export last --lerobot",
)  # of `frankie-task`
FAILS = ("run pick_one --scene single --world faulty",)  # as its page says, or may


def lines(page: Path) -> list[str]:
    """The console lines of a page, without comments."""
    blocks = [text for kind, text in BLOCK.findall(page.read_text("utf-8")) if kind == "console"]
    found = re.findall(r"^\$ (.*)$", "".join(blocks), re.MULTILINE)
    return [re.sub(r"\s+#.*", "", one).removeprefix(".venv/bin/") for one in found]


def reason(text: str) -> str:
    return next((why for begin, why in NOT_HERE.items() if text.startswith(begin)), "")


def run_here(page: Path) -> list[str]:
    """What is left to run, of which each is a command of ours."""
    left = [one for one in lines(page) if not reason(one)]
    assert [one for one in left if not one.startswith("frankie-task ")] == []
    return [one.removeprefix("frankie-task ") for one in left]


HERE = [page for page in PAGES if page.name not in WHOLE and run_here(page)]
LONG = [page for page in HERE if any(one.startswith(SLOW) for one in run_here(page))]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder of runs with one in it, whose images are kept."""
    folder = tmp_path_factory.mktemp("before")
    task = folder / "move.yaml"
    drives = "{drive: {forward_m: 0.3}}, {wait: {duration_s: 1}}, {drive: {turn_deg: 20}}"
    task.write_text(f"task: move\ntree: {{sequence: [move_arm: {{to: ready}}, {drives}]}}\n")
    run_task(RunOptions(tree=task, scene="single", record=folder / "runs", replayable=True))
    return folder / "runs"


@pytest.fixture
def folder(tmp_path, monkeypatch, runs):
    """Where a reader is: with the files that blocks name, the trees, and a run."""
    monkeypatch.chdir(tmp_path)
    Path("trees").symlink_to(ROOT / "trees")
    shutil.copytree(runs, "runs")
    for page in PAGES:
        if page.name not in WHOLE:
            for name, text in NAMED.findall(page.read_text("utf-8")):
                Path(name).write_text(text)


def follow(page: Path, slow: bool) -> None:
    for one in run_here(page):
        if slow and one.startswith("robot import ur5.urdf"):
            Path("ur5.urdf").symlink_to(EXAMPLES / "ur_description/urdf/ur5_robot.urdf")
        if slow or not one.startswith(SLOW):
            code, out, err = call(*shlex.split(one))
            assert code == 0 or one.startswith(FAILS), f"$ {one}\n{out}{err}"


@pytest.mark.parametrize("page", HERE, ids=lambda page: page.name)
def test_what_a_page_says_runs(folder, page):
    follow(page, slow=False)


@pytest.mark.slow
@pytest.mark.parametrize("page", LONG, ids=lambda page: page.name)
def test_what_takes_longer_runs_too(folder, page):
    follow(page, slow=True)


def blocks() -> list[tuple[str, str, str]]:
    """Page, kind and text of each block that is no console, and that is not left out."""
    every = [
        (page.name, kind, text)
        for page in PAGES
        if page.name not in WHOLE
        for kind, text in BLOCK.findall(page.read_text("utf-8"))
        if kind != "console"
    ]
    return [one for one in every if not reason(f"{one[0]} {one[1]} {one[2]}")]


@pytest.mark.parametrize(("page", "kind", "text"), blocks(), ids=lambda text: text[:20].strip())
def test_a_block_is_what_it_says(tmp_path, monkeypatch, page, kind, text):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "block.yaml"
    if kind == "json":
        for server in json.loads(text)["mcpServers"].values():
            assert parse([one.replace("/home/me/tasks", ".") for one in server["args"]])[0] == "mcp"
    elif kind == "python":
        exec(compile(text, page, "exec"), {})
    elif page == "simulation.md":
        path.write_text(text)
        less = {"outages": None, "moved": {}}
        assert load_localisation(str(path)).model_copy(update=less) == LEVELS["poor"]
    elif page == "scenes.md":
        path.write_text(text)
        assert call("check", path)[:2] == (0, f"{path}: good\n")
    else:
        assert (page, kind) == ("language.md", "yaml")
        region = "{centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}"
        head = f"task: t\nregions: {{box: {region}}}\ntree:\n  sequence:\n"
        path.write_text(head + indent(text, "    "))
        load(path)


def test_what_is_left_out_is_there():
    texts = [one for page in PAGES for one in lines(page)]
    for page in PAGES:
        texts += [f"{page.name} {kind} {text}" for kind, text in BLOCK.findall(page.read_text())]
    stale = [one for one in NOT_HERE if not any(text.startswith(one) for text in texts)]
    assert stale == []


def test_furniture_stands_where_the_scenes_page_says():
    text = (ROOT / "docs/scenes.md").read_text()
    row = r"^\| (.*`.*?) \| `(.+?)` \| (\S+), (\S+) \| (\S+), (\S+) \| ([\d., ]+) \|$"
    rows = re.findall(row, text, re.M)
    assert len(rows) > 10
    front = re.findall(r"`(\w+)`", rows[0][0])
    for scenes, piece, *numbers, heights in rows:
        named = re.findall(r"`(\w+)`", scenes)
        named += front[:6] if scenes.startswith("the first") else []
        for scene, height in product(named, map(float, heights.split(","))):
            boxes = [
                (one.pose.translation - half, one.pose.translation + half)
                for one in load_fixtures(scene, unmapped=True)
                if one.piece == piece
                for half in [np.abs(half_extents(one.shape))]
            ]
            boxes = [(low, high) for low, high in boxes if abs(high[2] - height) < 0.002]
            low = np.min([low for low, _ in boxes], axis=0)[:2]
            high = np.max([high for _, high in boxes], axis=0)[:2]
            stands = [*(low + high) / 2.0, *(high - low)]
            assert stands == pytest.approx(list(map(float, numbers)), abs=0.013), (scene, piece)
