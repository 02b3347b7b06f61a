"""What the robot has hit stands in the summary, and in the table if there is anything."""

from pathlib import Path

from rich.console import Console

from app.core import Result, RunOptions, run_task

SCENE = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
objects: {count: 0}
walkers:
  - {name: Ada, radius: 0.2, way: [[-0.5, -1.5], [-0.5, 1.5]], speed: 1.0}
"""
TASK = """\
task: stand
tree:
  wait: {duration_s: 3}
"""


def stood_in_the_way(folder: Path, *, of_somebody: bool) -> Result:
    """A robot that stands still, and somebody who runs into it, or not."""
    scene = SCENE if of_somebody else SCENE.partition("walkers:")[0]
    (folder / "scene.yaml").write_text(scene)
    (folder / "stand.yaml").write_text(TASK)
    return run_task(
        RunOptions(
            tree=folder / "stand.yaml",
            scene=str(folder / "scene.yaml"),
            record=folder / "runs",
        )
    )


def shown(result: Result) -> str:
    console = Console(record=True, width=120)
    result.summary.show(console)
    return console.export_text()


def test_contacts_are_counted_by_name_and_shown(tmp_path):
    result = stood_in_the_way(tmp_path, of_somebody=True)
    names = result.summary.contacts_by_name
    assert names["the base hit Ada"] == 1
    assert result.summary.contacts == sum(names.values())
    assert "the base hit Ada" in shown(result)


def test_where_nothing_is_hit_the_table_does_not_speak_of_it(tmp_path):
    result = stood_in_the_way(tmp_path, of_somebody=False)
    assert result.summary.contacts == 0
    assert "contacts" not in shown(result)
