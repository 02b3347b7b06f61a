"""The core works without extensions and laboratory, and says what is missing to who asks for it."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CORE = (
    *("app", "behaviours", "config", "controller", "frankie_task", "frankie_task_cli.py"),
    *("hw", "perception", "robots", "trees"),
)


@pytest.fixture(scope="module")
def core(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("core")
    for name in CORE:
        if (ROOT / name).is_dir():
            hidden = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, folder / name, ignore=hidden)
        else:
            shutil.copy(ROOT / name, folder)
    return folder


def done(core: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command of the core alone: this repository is not on the path."""
    ours = str(ROOT)
    program = (
        "import sys\n"
        f"others = [one for one in sys.path if one not in ('', {ours!r})]\n"
        f"sys.path[:] = [{str(core)!r}, *others]\n"
        "from frankie_task_cli import main\n"
        "main()"
    )
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        cwd=core,
        env={"PATH": "/usr/bin:/bin", "HOME": str(core)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "commands",
    [
        ["run pick_one --seed 3 --view none", "explain", "runs"],
        ["check pick_place"],
        ["new hello"],
        ["nodes grasp"],
        ["dry pick_one"],
        ["drivers"],
    ],
    ids=lambda commands: commands[0].split()[0],
)
def test_what_the_core_does_needs_no_extension(core, commands):
    for command in commands:
        ended = done(core, *command.split())
        assert ended.returncode in ((0, 1) if command[:3] == "dry" else (0,)), ended.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("run", "pick_one", "--world", "physics"), "physics"),
        (("run", "pick_one", "--with", "page", "--view", "none"), "page"),
        (("serve",), "serve"),
    ],
)
def test_who_asks_for_an_extension_hears_that_it_is_not_there(core, words, name):
    ended = done(core, *words)
    assert ended.returncode == 2
    assert f"`{name}` of frankie-task 0.1.0 cannot be used" in ended.stderr
    assert "Traceback" not in ended.stderr
