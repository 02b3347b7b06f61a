"""`bench experiments` runs the list of the docs and reports changed figures."""

import json
from pathlib import Path

from bench_call import call

from config.reader import read_config
from lab.bench.regenerate import Experiments

DOCS = Path(__file__).parents[3] / "docs"

READING = """\
experiments:
  - table: reading
    command: reach --robot omni --base-speed 1.5 --limit 0.1 --count 3 --workers 1
    quick: --seed 1
    figures:
      - [time, results.0.period_s, 0, 1.0e+9]
      - [reads, results.0.goals, {reads}, 0]
"""


def regenerate(tmp_path, text: str, *arguments: str) -> tuple[int, str, str]:
    file = tmp_path / "list.yaml"
    file.write_text(text)
    options = ["--folder", tmp_path / "out", "--json", tmp_path / "out.json"]
    return call("experiments", file, *options, *arguments)


def rows(tmp_path):
    kept = json.loads((tmp_path / "out.json").read_text())["results"]
    return [(row["name"], row["was"], row["now"], row["changed"]) for row in kept]


def test_a_figure_outside_its_tolerance_is_a_change(tmp_path):
    code, out, _ = regenerate(tmp_path, READING.format(reads=5))
    assert code == 1
    assert "CHANGED" in out
    assert "2 figures, 1 changed" in out
    time, reads = rows(tmp_path)
    assert time[2] > 0.0
    assert not time[3]
    assert reads == ("reads", 5.0, 3.0, True)


def test_small_sizes_are_not_judged(tmp_path):
    code, out, _ = regenerate(tmp_path, READING.format(reads=5), "--quick")
    assert code == 0
    assert "CHANGED" not in out
    assert rows(tmp_path)[1] == ("reads", 5.0, 3.0, False)


def test_errors_of_the_list_are_one_line(tmp_path):
    wrong = READING.format(reads=3).replace("0.goals", "0.gaols")
    code, _, err = regenerate(tmp_path, wrong, "--quick")
    assert code == 2
    assert "reading: its JSON has no figure at `results.0.gaols`" in err
    code, _, err = regenerate(tmp_path, wrong.replace("omni", "omnx"))
    assert code == 2
    assert "exit code 2" in err
    assert regenerate(tmp_path, wrong, "--only", "poses")[0] == 2


def test_every_table_of_the_shipped_list_is_on_the_page():
    page = (DOCS / "experiments.md").read_text(encoding="utf-8")
    for one in read_config(DOCS / "experiments.yaml", Experiments).experiments:
        assert f"## {one.table.partition(',')[0]}" in page, one.table
