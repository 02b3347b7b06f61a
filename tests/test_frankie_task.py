"""The one face for authors and scripts, and the entry point that guards the package names."""

import os
import pydoc
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

import frankie_task
import frankie_task_cli
from frankie_task import control

ROOT = Path(frankie_task.__file__).parents[1]


def test_everything_promised_is_there():
    for face in (frankie_task, control):
        for name in face.__all__:
            assert getattr(face, name) is not None


def test_help_lists_the_controller_and_the_standard_terms():
    """What `help` lists of a module is what its `__all__` names."""
    public = {name for name in vars(control) if not name.startswith("_")}
    assert set(control.__all__) == public
    assert "class HolisticController" in pydoc.plaintext.document(control)
    assert control.terms.tracking in control.STANDARD_TERMS


def test_a_script_runs_a_task(tmp_path):
    task = tmp_path / "go.yaml"
    task.write_text("task: go\nparams: {far: {default: 0.1}}\ntree: {drive: {forward_m: $far}}\n")
    options = {"scene": "single", "seed": 1, "parameters": {"far": "0.2"}}
    result = frankie_task.run_task(task, record=tmp_path / "runs", **options)
    assert result.outcome.end.exit_code == 0
    assert result.summary.seed == 1
    assert np.load(result.folder / "states.npy")[-1, 1] == pytest.approx(0.2, abs=0.05)
    assert (result.folder / "recording.rrd").is_file()


def test_a_script_gets_bad_input_as_one_line(tmp_path):
    with pytest.raises(frankie_task.UserError, match="did you mean `pick_one`"):
        frankie_task.run_task("pick_on", record=tmp_path)


def test_the_command_enters_where_names_are_guarded():
    [script] = entry_points(group="console_scripts", name="frankie-task")
    assert script.load() is frankie_task_cli.main


def ran(program: str, *arguments: object, first: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """A program of Python with arguments, and a folder in which it looks for packages first."""
    return subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": f"{first}{os.pathsep}{ROOT}"},
        cwd=first,
        capture_output=True,
        text=True,
        check=False,
    )


MAIN = "from frankie_task_cli import main; main()"


def test_a_foreign_package_of_the_same_name_is_refused_by_one_line(tmp_path):
    path = tmp_path / "controller.py"
    path.write_text("raise RuntimeError('this is not ours')\n")
    done = ran(MAIN, "nodes", first=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{path}: hides the package `controller` of frankie-task; ")
    assert done.stderr.count("\n") == 1


def test_the_command_line_is_quick_to_answer():
    """Nothing heavy is loaded for `--help`."""
    heavy = ("pydantic", "torch", "rerun", "pinocchio", "cv2", "py_trees")
    program = (
        "import sys; from frankie_task_cli import main\n"
        "try: main()\n"
        f"except SystemExit: print([name for name in {heavy} if name in sys.modules])"
    )
    assert ran(program, "--help").stdout.splitlines()[-1] == "[]"


def test_a_wrong_word_is_answered_by_the_nearest_command():
    assert "did you mean 'check'" in ran(MAIN, "chek").stderr.lower()
