"""What the robot has hit stands in the summary, and in the table if there is anything."""

from rich.console import Console

from app.core import RunOptions, run_task

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
  wait: {duration_s: 2}
"""


def test_contacts_are_counted_by_name_and_shown(tmp_path):
    (tmp_path / "stand.yaml").write_text(TASK)
    for scene, hits in ((SCENE, 1), (SCENE.partition("walkers:")[0], 0)):
        (tmp_path / "scene.yaml").write_text(scene)
        result = run_task(
            RunOptions(
                tree=tmp_path / "stand.yaml",
                scene=str(tmp_path / "scene.yaml"),
                record=tmp_path / "runs",
                recording=False,
            )
        )
        console = Console(record=True, width=120)
        result.summary.show(console)
        names = result.summary.contacts_by_name
        assert result.summary.contacts == sum(names.values())
        assert names.get("the base hit Ada", 0) == hits
        assert ("the base hit Ada" in console.export_text()) == bool(hits)
