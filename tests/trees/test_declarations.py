"""What `check` reads instead of the classes of the leaves."""

import subprocess
import sys
from pathlib import Path

import pytest

from behaviours import LEAVES
from trees.language import DECLARATIONS, check, declarations_text, describe_leaves
from trees.language.registry import declared_leaves

HEAVY = ("numpy", "pinocchio", "cv2", "torch", "coal")


def test_the_file_is_what_the_classes_say():
    text = declarations_text(describe_leaves(LEAVES))
    assert DECLARATIONS.read_text(encoding="utf-8") == text, "make it anew: make declarations"


def test_arguments_that_do_not_fit_each_other_are_found_without_the_class():
    for key, leaf in describe_leaves(LEAVES).items():
        assert (declared_leaves()[key].validate is None) == (leaf.validate is None)
    validate = declared_leaves()["say"].validate
    assert validate is not None
    assert "has only one of" in validate({"text": "{value}"})


@pytest.mark.parametrize("wrong", [False, True], ids=["good", "bad"])
def test_a_task_without_places_is_checked_without_numbers_and_kinematics(tmp_path: Path, wrong):
    task = tmp_path / "plain.yaml"
    value = "a text" if wrong else 1
    task.write_text(
        "task: plain\n"
        "tree:\n"
        "  sequence:\n"
        "    - open_gripper\n"
        "    - battery_above: {percent: 20}\n"
        "    - say: {text: 'all is well'}\n"
        f"    - wait: {{duration_s: {value}}}\n"
    )
    assert bool(check(task)) == wrong
    program = (
        "import sys\n"
        "from trees.site import check\n"
        f"print(len(check({str(task)!r})), *[name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["1" if wrong else "0"]
