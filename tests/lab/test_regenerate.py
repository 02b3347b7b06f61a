"""`bench experiments` runs the list of the docs, and tells what has changed."""

import json
from pathlib import Path

from typer.testing import CliRunner

from app.commands import app
from config import read_config
from lab.bench import Experiments

DOCS = Path(__file__).parents[2] / "docs"

REACH = """\
experiments:
  - table: reach
    command: reach --robot omni --base-speed 1.0 --count 4 --workers 1
    quick: --count 2
    figures:
      - [failed, results.0.failures, 0, 0]
      - [goals, results.0.goals, {goals}, 0]
"""


def call(tmp_path, text: str, *arguments: str):
    file = tmp_path / "list.yaml"
    file.write_text(text)
    options = ["--folder", str(tmp_path / "left"), "--json", str(tmp_path / "out.json")]
    return CliRunner().invoke(app, ["bench", "experiments", str(file), *options, *arguments])


def test_a_figure_that_is_as_it_was_is_no_change_and_another_is(tmp_path):
    same = call(tmp_path, REACH.format(goals=4))
    assert same.exit_code == 0, same.output
    assert "2 figures, 0 changed" in same.stdout
    other = call(tmp_path, REACH.format(goals=5))
    assert other.exit_code == 1
    assert "CHANGED" in other.stdout
    rows = json.loads((tmp_path / "out.json").read_text())["results"]
    assert [(row["name"], row["was"], row["now"], row["changed"]) for row in rows] == [
        ("failed", 0.0, 0.0, False),
        ("goals", 5.0, 4.0, True),
    ]


def test_small_sizes_are_not_judged(tmp_path):
    result = call(tmp_path, REACH.format(goals=4), "--quick")
    assert result.exit_code == 0, result.output
    assert "CHANGED" not in result.stdout
    rows = json.loads((tmp_path / "out.json").read_text())["results"]
    assert rows[1]["now"] == 2.0


def test_what_is_wrong_with_the_list_is_said_in_a_line(tmp_path):
    missing = call(tmp_path, REACH.format(goals=4).replace("0.goals", "0.gaols"), "--quick")
    assert missing.exit_code == 2
    assert "reach: its JSON has no figure at `results.0.gaols`" in missing.stderr
    failed = call(tmp_path, REACH.format(goals=4).replace("--robot omni", "--robot omny"))
    assert failed.exit_code == 2
    assert "exit code 2" in failed.stderr
    nothing = call(tmp_path, REACH.format(goals=4), "--only", "poses")
    assert nothing.exit_code == 2


def test_every_table_of_the_shipped_list_is_on_the_page():
    page = (DOCS / "experiments.md").read_text(encoding="utf-8")
    for one in read_config(DOCS / "experiments.yaml", Experiments).experiments:
        assert f"## {one.table.partition(',')[0]}" in page, one.table
