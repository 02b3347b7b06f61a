"""A recorded run, replayed: the same commands bit for bit, or the first difference by name."""

import json
import re
import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from pinocchio import SE3
from recorded_runs import RECORDED, Recorded, record

from app.choices import Speed
from app.core import Instruments, ObstacleSource, Tick, replay_run
from app.core.files.frames import FrameStream, RecordedFrames
from hw import DepthFrame
from robots import load_robot

TOY = """\
task: toy
poses: {near: {xyz: [0.9, 0.2, 0.7], rpy_deg: [180, 0, 0]}}
tree: {sequence: [{wait: {duration_s: 0.2}}, {navigate: {to: near}}]}
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory) -> Path:
    """The folder of a short run; not to be changed."""
    here = tmp_path_factory.mktemp("toy")
    (here / "toy.yaml").write_text(TOY)
    return record(Recorded(tree=str(here / "toy.yaml"), scene="single"), here / "runs")


@pytest.fixture
def folder(toy, tmp_path) -> Path:
    """A copy of it, to change."""
    return Path(shutil.copytree(toy, tmp_path / toy.name))


def replayed(folder: Path) -> tuple[int, str]:
    code, out, err = call("replay", folder)
    return code, (out + err).strip()


def change(folder: Path, turn: int, field: str, bit: int) -> None:
    """Turn over one bit of a field of one turn."""
    readings = np.lib.format.open_memmap(folder / "readings.npy", mode="r+")
    readings[field].view(np.uint64)[turn].flat[0] ^= np.uint64(1 << bit)
    readings.flush()


def test_a_run_of_an_older_version_is_replayed_and_explained():
    old = Path(__file__).parent / "run_of_version_3"
    assert replayed(old) == (0, "all 32 commands are identical, bit for bit")
    code, out, _ = call("explain", old)
    assert (code, out.splitlines()[2]) == (0, "It succeeded: open_gripper: open")


def test_one_changed_bit_of_a_reading_is_found_and_named(toy, folder):
    count = len(np.load(toy / "commands.npy"))
    assert replayed(toy) == (0, f"all {count} commands are identical, bit for bit")
    change(folder, 100, "q", 30)
    code, text = replayed(folder)
    found = re.fullmatch(r"command (\d+) at (\S+) s differs in .*: recorded .*, replayed .*", text)
    assert code == 1
    assert 100 <= int(found[1]) <= 102
    assert float(found[2]) == pytest.approx(0.01 * int(found[1]), abs=0.011)


def test_one_changed_bit_of_a_command_is_found_and_named(folder):
    recorded = float(np.load(folder / "readings.npy")["command"][100, 0])
    change(folder, 100, "command", 0)
    changed = float(np.load(folder / "readings.npy")["command"][100, 0])
    told = f"command 100 at 1.00 s differs in base vx: recorded {changed!r}, replayed {recorded!r}"
    assert replayed(folder) == (1, told)


def test_a_replay_that_goes_on_where_the_run_ended_is_no_success_unless_it_was_cut_off(folder):
    np.save(folder / "readings.npy", np.load(folder / "readings.npy")[:80])
    assert replayed(folder) == (1, "the replay goes on after the last of 80 recorded commands")
    lines = (folder / "readings.jsonl").read_text().splitlines()
    (folder / "readings.jsonl").write_text(lines[0] + "\n")
    told = "all 80 commands are identical, bit for bit; the recording was cut off there"
    assert replayed(folder) == (0, told)


def test_readings_that_are_missing_are_refused_in_one_line(folder):
    np.save(folder / "readings.npy", np.load(folder / "readings.npy")[5:])
    code, text = replayed(folder)
    assert (code, "missing" in text, len(text.splitlines())) == (2, True, 1)


def test_a_run_that_looked_at_images_needs_them_and_not_beside_the_loop(tmp_path):
    looks = {"tree": "pick_one", "scene": "single", "obstacles": ObstacleSource.BOTH}
    folder = record(Recorded(**looks, frames=False, seconds=0.5), tmp_path)
    code, text = replayed(folder)
    assert (code, "run it with --replayable" in text) == (2, True)
    options = json.loads((folder / "options.json").read_text())
    (folder / "options.json").write_text(json.dumps(options | {"real_time": True}))
    code, text = replayed(folder)
    assert (code, "in real time" in text) == (2, True)


SHORT = Recorded(
    tree="pick_one",
    scene="single",
    obstacles=ObstacleSource.BOTH,
    faults=("localisation jump@0.5",),
    seconds=1.5,
)
ASTRAY = replace(SHORT, localisation="good")


@pytest.mark.parametrize(
    "run",
    [ASTRAY, *(pytest.param(one, marks=pytest.mark.slow) for one in (SHORT, *RECORDED))],
    ids=str,
)
def test_recorded_runs_are_replayed_bit_for_bit(run, tmp_path):
    replay = replay_run(record(run, tmp_path))
    assert replay.identical, str(replay)
    assert replay.recorded > (100 if run in (SHORT, ASTRAY) else 300)


@pytest.fixture(scope="module")
def localised(tmp_path_factory):
    """A run of a base that does not know exactly where it is."""
    return record(replace(ASTRAY, seconds=0.5, faults=()), tmp_path_factory.mktemp("localised"))


def test_a_scan_that_is_missing_is_told_in_one_line(localised, tmp_path):
    copy = Path(shutil.copytree(localised, tmp_path / "copy"))
    notes = copy / "readings.jsonl"
    kept = [line for line in notes.read_text().splitlines() if '"scan"' not in line]
    notes.write_text("\n".join(kept) + "\n")
    code, text = replayed(copy)
    assert (code, "scan 1 is missing" in text, len(text.splitlines())) == (2, True, 1)


def test_the_summary_and_the_explanation_say_in_one_line_how_it_was_localised(localised):
    line = json.loads((localised / "summary.json").read_text())["localisation"]
    assert line.startswith("good, registered to the map by laser and camera ")
    assert " times, corrected by at most " in line
    assert f"Localisation: {line}" in " ".join(call("explain", localised)[1].split())


class Slow(Instruments):
    """Every tenth tick takes three periods."""

    def after(self, tick: Tick) -> None:
        if tick.number % 10 == 0:
            time.sleep(0.03)


@pytest.mark.realtime
def test_in_real_time_nothing_is_left_out_on_a_computer_that_is_too_slow(tmp_path):
    fast = record(SHORT, tmp_path / "fast")
    slow = record(replace(SHORT, speed=Speed.REAL), tmp_path / "slow", instruments=Slow())
    sent = [np.load(folder / "commands.npy") for folder in (fast, slow)]
    np.testing.assert_array_equal(*sent)
    assert json.loads((slow / "summary.json").read_text())["missed_ticks"] == 0


def test_recorded_colours_come_back_as_they_were(tmp_path):
    camera = load_robot("frankie").camera.intrinsics
    rng = np.random.default_rng(0)
    depth = rng.random((48, 64), dtype=np.float32)
    colour = rng.integers(0, 256, (48, 64, 3), dtype=np.uint8)
    frames = [
        DepthFrame(depth=depth, intrinsics=camera, oTc=SE3.Identity(), stamp=s, paint=c)
        for s, c in ((0.0, lambda: colour), (0.1, None))
    ]
    path = tmp_path / "frames.arrows"
    path.write_bytes(FrameStream()(list(enumerate(frames, 1))))
    read = RecordedFrames(path, camera)
    assert (read(1).colour == colour).all()
    second = read(2)
    assert second.colour is None
    assert (second.depth == depth).all()
