"""What `check` reads instead of the classes of the leaves."""

import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from tree_toys import check

from behaviours import LEAVES, grasp
from trees.language import ADD, SET, declared_leaves, describe_leaves, registry

HEAVY = ("numpy", "pinocchio", "cv2", "torch", "coal")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch) -> Path:
    """Where nothing is kept yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "frankie-task"


def kept_in(cache: Path) -> Path:
    [kept] = cache.iterdir()
    return kept


def test_what_is_kept_is_what_the_classes_say(cache):
    said = {key: describe_leaves(LEAVES)[key].deferred() for key in LEAVES}
    for _ in range(2):  # made, and read
        assert declared_leaves() == said | {"set": SET, "add": ADD}
        assert declared_leaves()["set"] is SET
        assert kept_in(cache).stat().st_size < 100_000


def test_arguments_that_do_not_fit_each_other_are_found_without_the_class(cache):
    declared_leaves()
    for key, leaf in describe_leaves(LEAVES).items():
        assert (declared_leaves()[key].validate is None) == (leaf.validate is None)
    validate = declared_leaves()["say"].validate
    assert "has only one of" in validate({"text": "{value}"})


@pytest.mark.parametrize("change", ["damaged", "of other sources"])
def test_what_is_kept_wrongly_is_made_again(cache, change):
    whole = declared_leaves()
    good = kept_in(cache).read_bytes()
    stamps, leaves = pickle.loads(good)
    del leaves["wait"]
    stamps[grasp.__file__] -= 1
    bad = good[:-9] if change == "damaged" else pickle.dumps((stamps, leaves))
    kept_in(cache).write_bytes(bad)
    assert declared_leaves() == whole
    assert kept_in(cache).read_bytes() == good


def test_a_source_that_changes_while_a_program_runs_is_not_kept_as_it_was(cache, monkeypatch):
    newest = max(Path(grasp.__file__).parent.rglob("*.py"), key=lambda path: path.stat().st_mtime)
    monkeypatch.setattr(registry, "_BEGUN", newest.stat().st_mtime_ns)
    assert "wait" in declared_leaves()
    assert not cache.exists()


def test_without_a_place_to_keep_it_the_classes_are_asked(cache):
    cache.write_text("no folder")
    assert "wait" in declared_leaves()


@pytest.mark.parametrize("wrong", [False, True], ids=["good", "bad"])
def test_a_task_without_places_is_checked_without_numbers_and_kinematics(tmp_path: Path, wrong):
    task = tmp_path / "plain.yaml"
    value = "a text" if wrong else 1
    leaves = f"battery_above: {{percent: 20}}, say: {{text: well}}, wait: {{duration_s: {value}}}"
    task.write_text(f"task: plain\ntree: {{sequence: [open_gripper, {leaves}]}}\n")
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
