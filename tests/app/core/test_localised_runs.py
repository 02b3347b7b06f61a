"""A run of a base that does not know exactly where it is: kept, replayed, summed up."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from pinocchio import SE3
from recorded_runs import Recorded, record

from app.core.files.notes import note, read_notes
from hw import LaserScan, LocalisedPose

WAIT = """\
task: wait_a_little
tree:
  wait: {duration_s: 0.3}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    here = tmp_path_factory.mktemp("localised")
    (here / "task.yaml").write_text(WAIT)
    run = Recorded(tree=str(here / "task.yaml"), scene="single", localisation="good")
    return record(run, here / "runs")


def test_a_scan_that_is_missing_is_told_in_one_line(folder, tmp_path):
    copy = Path(shutil.copytree(folder, tmp_path / folder.name))
    notes = copy / "readings.jsonl"
    kept = [line for line in notes.read_text().splitlines() if '"scan"' not in line]
    notes.write_text("\n".join(kept) + "\n")
    code, out, err = call("replay", copy)
    assert code == 2
    assert len((out + err).splitlines()) == 1
    assert "scan 1 is missing" in out + err


def test_the_summary_and_the_explanation_say_in_one_line_how_it_was_localised(folder):
    line = json.loads((folder / "summary.json").read_text())["localisation"]
    assert line.startswith("good, registered to the map by laser and camera ")
    assert " times, corrected by at most " in line
    code, out, _ = call("explain", folder)
    assert code == 0
    assert f"Localisation: {line}" in " ".join(out.split())


def test_notes_come_back_bit_for_bit():
    rng = np.random.default_rng(0)
    pose = SE3.Random()
    points = rng.normal(size=(5, 3))
    points[2] = np.nan
    scan = LaserScan(stamp=0.1 + 0.2, ranges=points[:, 0].copy(), points=points, oTb=pose)
    localised = LocalisedPose(stamp=1.0 / 3.0, mTb=pose, covariance=rng.normal(size=(3, 3)))
    things = {("scan", 7): scan, ("localised", 3): localised}
    text = "\n".join(json.dumps(note(*key, thing)) for key, thing in things.items())
    read = read_notes(text).noted
    assert read.keys() == things.keys()
    for key, thing in things.items():
        for name, value in vars(thing).items():
            got = getattr(read[key], name)
            same = np.array(got) if not isinstance(value, SE3) else got.homogeneous
            was = np.array(value) if not isinstance(value, SE3) else value.homogeneous
            assert same.tobytes() == was.tobytes()
