"""docs/control_library.md is followed from its first line to its last, on the UR5 that it names."""

import shlex
from pathlib import Path

import pytest
from command_line import call
from example_robots import EXAMPLES
from test_documents import ROOT
from test_documents_run import BLOCK, run_here

PAGE = ROOT / "docs" / "control_library.md"


@pytest.mark.slow
def test_every_example_of_the_page_does_what_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("ur5.urdf").symlink_to(EXAMPLES / "ur_description/urdf/ur5_robot.urdf")
    for line in run_here(PAGE):
        assert call(*shlex.split(line))[0] == 0
    known: dict[str, object] = {}
    for kind, text in BLOCK.findall(PAGE.read_text("utf-8")):
        if kind == "python":
            exec(compile(text, PAGE.name, "exec"), known)
