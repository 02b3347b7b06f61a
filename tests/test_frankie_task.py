"""The one face for authors and scripts, and the entry point that guards the package names."""

import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

import frankie_task
import frankie_task_cli

ROOT = Path(frankie_task.__file__).parent


def test_everything_promised_is_there():
    for name in frankie_task.__all__:
        assert getattr(frankie_task, name) is not None


def test_a_script_runs_a_task(tmp_path):
    result = frankie_task.run_task("pick_one", scene="single", seed=1, record=tmp_path)
    assert result.outcome.end.exit_code == 0
    assert result.summary.placed == 1
    assert (result.folder / "recording.rrd").is_file()


def test_a_script_gets_bad_input_as_one_line(tmp_path):
    with pytest.raises(frankie_task.UserError, match="did you mean `pick_one`"):
        frankie_task.run_task("pick_on", record=tmp_path)


def test_the_command_enters_where_names_are_guarded():
    [script] = entry_points(group="console_scripts", name="frankie-task")
    assert script.load() is frankie_task_cli.main


@pytest.mark.parametrize(
    ("file", "package"),
    [("controller.py", "controller"), ("hw/__init__.py", "hw"), ("app.py", "app")],
)
def test_a_foreign_package_of_the_same_name_is_refused_by_one_line(tmp_path, file, package):
    path = tmp_path / file
    path.parent.mkdir(exist_ok=True)
    path.write_text("raise RuntimeError('this is not ours')\n")
    command = [sys.executable, "-c", "from frankie_task_cli import main; main()", "nodes"]
    environment = os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"{path}: hides the package `{package}` of frankie-task; ")
    assert done.stderr.count("\n") == 1


def test_the_command_line_is_quick_to_answer():
    """Nothing heavy is loaded for `--help`."""
    heavy = ("pydantic", "torch", "rerun", "pinocchio", "cv2", "py_trees")
    program = (
        "import sys; from frankie_task_cli import main\n"
        "try: main()\n"
        f"except SystemExit: print([name for name in {heavy} if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, "--help"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_to_check_a_task_without_places_reads_no_robot(tmp_path):
    """Places need one, and so does whoever names a robot file, which may have mistakes."""
    task = tmp_path / "waits.yaml"
    task.write_text("task: waits\ntree: {wait: {duration_s: 1}}\n")
    program = (
        "import sys; from frankie_task_cli import main\n"
        "opened = []\n"
        "sys.addaudithook(lambda event, args: event == 'open' and opened.append(str(args[0])))\n"
        "try: main()\n"
        "finally: print(*[name for name in opened if name.endswith('.yaml')])"
    )

    def opened(*words: str) -> str:
        command = [sys.executable, "-c", program, "check", *words]
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return done.stdout.splitlines()[-1]

    assert "/parts/" not in opened(str(task))
    assert "panda.yaml" in opened("pick_one")
    assert "panda.yaml" in opened(
        str(task), "--robot", str(ROOT.parent / "robots" / "frankie.yaml")
    )


def test_the_command_line_answers_alike_whatever_it_builds():
    """A command is built alone; what calls none is answered by all of them."""
    program = "from frankie_task_cli import main; main()"

    def said(*words: str) -> str:
        command = [sys.executable, "-c", program, *words]
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        return done.stdout + done.stderr

    assert "check [OPTIONS]" in said("check", "--help")
    assert "bench timing [OPTIONS]" in said("bench", "timing", "--help")
    assert "did you mean 'check'" in said("chek").lower()
    assert all(word in said("--help") for word in ("check", "draw", "bench", "run"))
