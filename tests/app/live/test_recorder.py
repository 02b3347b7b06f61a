"""A recording, read back: what every part of the picture is drawn from, and when."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import sample_run as samples
from pinocchio import SE3, Quaternion
from recordings import poses, record, recorder, rows, static, with_component
from rerun.chunk import RrdReader

from app.live import RecorderError, Snapshot
from app.live.monitor.signals_panel import PLOTS
from app.live.monitor.tree_panel import MARK
from controller import robot_model

TICKS = 300
LATENCY = 0.047
"""Between capture and arrival of a frame [s]; not a multiple of the sample run's period."""


@pytest.fixture(scope="module")
def snapshots() -> list[Snapshot]:
    return list(samples.run(TICKS))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, snapshots: list[Snapshot]) -> Path:
    return record(tmp_path_factory.mktemp("run") / "recording.rrd", snapshots)


def test_every_part_of_the_picture_is_in_the_file(recording: Path) -> None:
    chunks = RrdReader(recording).stream().to_chunks()
    links = [f"/world/robot/link{i}" for i in range(8)]
    assert {chunk.entity_path for chunk in chunks} >= {
        *(f"/tree/list/{part}" for part in ("pills", "edges", "labels")),
        *("/status", "/now", "/log"),
        *("/world/fixtures", "/world/grasp"),
        *("/world/objects/0_box_1", "/world/objects/1_mug", "/world/objects/2_ball_and_bar"),
        *("/world/robot/base", "/world/robot/hand", *links),
        *("/world/robot/left_finger", "/world/robot/right_finger", "/world/poses"),
        *("/world/camera", "/world/camera/depth", "/world/camera/quality", "/world/camera/grasps"),
        *("/world/fault", "/world/ghost/hand", "/world/ghost/base"),
        *("/world/way", "/world/nearest", "/world/regions"),
        *(f"/signals/{signal}" for signal in PLOTS),
    }


def test_signals_have_a_row_every_tick(recording: Path, snapshots: list[Snapshot]) -> None:
    limits = robot_model("frankie").limits.qd
    velocities = rows(recording, "/signals/joint_velocity")
    assert [row["tick"] for row in velocities] == list(range(TICKS))
    np.testing.assert_allclose(
        [row["t"] for row in velocities], [snapshot.stamp for snapshot in snapshots], atol=1e-6
    )
    np.testing.assert_allclose(
        [row["scalars"] for row in velocities],
        [snapshot.command.qd / limits for snapshot in snapshots],
    )
    for entity, given in {
        "manipulability": [[s.report.manipulability] for s in snapshots],
        "slack": [[s.report.slack] for s in snapshots],
        "tick": [[1000.0 * s.seconds] for s in snapshots],
        "base_velocity": [s.command.base_twist[:2] for s in snapshots],
        "base_rotation": [s.command.base_twist[2:] for s in snapshots],
    }.items():
        kept = [row["scalars"] for row in rows(recording, f"/signals/{entity}")]
        np.testing.assert_allclose(kept, given, err_msg=entity)
    assert rows(recording, "/signals/distance")[100]["scalars"] == pytest.approx([2.0])
    assert rows(recording, "/signals/angle")[100]["scalars"] == pytest.approx([0.2, 0.1])


def test_history_is_activity_with_a_mark_where_it_ends(recording: Path) -> None:
    kept = sorted(rows(recording, "/status"), key=lambda row: row["t"])
    names = [node.name for node in samples.TREE]
    grasp, asked = names.index("grasp 🤖"), names.index("region empty?")

    def line(index: int) -> list[tuple[float, str]]:
        states = [(round(row["t"], 3), row["state"][index].partition("|")[2]) for row in kept]
        return [s for i, s in enumerate(states) if i == 0 or s[1] != states[i - 1][1]]

    ended = 250 * samples.PERIOD
    begun = 170 * samples.PERIOD
    assert line(grasp) == [
        (0.0, ""),
        (begun, "running"),
        (ended, "not yet"),
        (round(ended + MARK, 3), ""),
    ]
    asked_at = 30 * samples.PERIOD
    assert line(asked) == [(0.0, ""), (asked_at, "not yet"), (round(asked_at + MARK, 3), "")]
    values = static(recording, "/status", "StateConfiguration:values")
    labels = static(recording, "/status", "StateConfiguration:labels")
    named = dict(zip(values, labels, strict=True))
    assert named["8|running"] == "navigate to above_container"
    assert named["8|success"] == "✔"
    assert set().union(*(row["state"] for row in kept)) - {""} <= set(named)


def test_pills_tell_status_by_colour_and_glyph(recording: Path) -> None:
    pills = with_component(recording, "/tree/list/pills", "colors")
    labels = with_component(recording, "/tree/list/labels", "labels")
    last = dict(zip(labels[-1]["labels"], pills[-1]["colors"], strict=True))
    colours = {label[0]: {c for text, c in last.items() if text[0] == label[0]} for label in last}
    assert set(colours) == set("▶✔○·"), "a failure that the tree goes on after is not red"
    assert all(len(of_glyph) == 1 for of_glyph in colours.values())
    assert len(set().union(*colours.values())) == 4
    assert "○ → pick once" in last
    assert "○ grasp □" in last, "a character that the viewer cannot draw must not reach it"


def test_log_tells_transitions_with_their_reasons(recording: Path) -> None:
    log = [(row["tick"], row["level"][0], row["text"][0]) for row in rows(recording, "/log")]
    assert log[0] == (0, "INFO", "   0.00 s  ▶ recover: 3.00 m to go □")
    assert (30, "INFO", "   0.60 s  ○ region empty?: nothing held") in log
    assert [text for tick, _, text in log if tick == 250] == [
        "   5.00 s  ✗ grasp □: nothing held",
    ]


def test_the_node_under_way_is_named_with_its_message(recording: Path) -> None:
    now = rows(recording, "/now")
    assert now[0]["text"][0].startswith("### ▶ recover\n\n3\\.00 m to go □")
    assert "*forever / main / until empty / pick / pick once*" in now[20]["text"][0]
    gaps = np.diff([row["t"] for row in now])
    assert len(now) < TICKS / 5, "a message that changes every tick is not kept every tick"
    assert gaps.max() < 0.3


def test_the_robot_stands_where_it_was(recording: Path, snapshots: list[Snapshot]) -> None:
    model = robot_model("frankie")
    for entity, pose_of in {
        "base": lambda s: s.state.oTb,
        "link4": lambda s: model.link_poses(s.state.oTb, s.state.q)[4],
        "hand": lambda s: model.link_poses(s.state.oTb, s.state.q)[8],
    }.items():
        kept = poses(recording, f"world/robot/{entity}")
        assert len(kept) >= TICKS / 6
        for row in kept[::20]:
            told = SE3(Quaternion(np.array(row["quaternion"][0])), np.array(row["translation"][0]))
            assert told.isApprox(pose_of(snapshots[row["tick"]]), 1e-5)
    left, right = (poses(recording, f"world/robot/{side}_finger") for side in ("left", "right"))
    for a, b in zip(left[::20], right[::20], strict=True):
        gap = np.linalg.norm(np.subtract(a["translation"], b["translation"]))
        assert gap == pytest.approx(snapshots[a["tick"]].state.gripper_width, abs=1e-6)


def test_the_grasp_is_drawn_only_while_there_is_one(
    recording: Path, snapshots: list[Snapshot]
) -> None:
    grasps = rows(recording, "/world/grasp")
    assert any(row["labels"] == ["0.90 locked"] for row in grasps)
    for row in grasps:
        assert len(row["strips"]) == (1 if snapshots[row["tick"]].grasp is not None else 0)


def test_objects_are_kept_when_they_move(tmp_path: Path) -> None:
    first, *others = samples.OBJECTS
    run = list(samples.run(60))
    for tick in range(30, 60):
        moved = first.copy()
        moved.translation += [0.0, 0.0, 0.01 * min(tick - 29, 10)]
        run[tick] = replace(run[tick], objects=(moved, *others))
    path = record(tmp_path / "x.rrd", run)
    lifted = poses(path, "world/objects/0_box_1")
    assert lifted[0]["tick"] == 0
    assert all(30 <= row["tick"] <= 40 for row in lifted[1:])
    assert lifted[-1]["translation"][0][2] == pytest.approx(0.476 + 0.1)
    assert len(poses(path, "world/objects/1_mug")) == 1


def test_depth_is_kept_to_the_millimetre_with_what_was_found(
    recording: Path, snapshots: list[Snapshot]
) -> None:
    images = rows(recording, "/world/camera/depth")
    assert [row["tick"] for row in images] == list(range(170, 300, 20))
    for row in images:
        frame = snapshots[row["tick"]].frame
        assert frame is not None
        kept = cv2.imdecode(np.array(row["blob"][0], np.uint8), cv2.IMREAD_UNCHANGED)
        assert (kept == np.rint(np.nan_to_num(frame.depth) * 1000)).all()
        assert (kept[0, 0], kept.max() > 500) == (0, True)
    heat, outlines = (rows(recording, f"/world/camera/{name}") for name in ("quality", "grasps"))
    for others in (heat, outlines):
        assert [row["tick"] for row in others] == [row["tick"] for row in images]
    for row, outline in zip(heat, outlines, strict=True):
        found = snapshots[row["tick"]].detection
        steps = np.array(row["buffer"][0], np.uint8).reshape(120, 160)
        if found is None:
            assert not steps.any()
            assert outline["strips"] == []
        else:
            v, u = np.unravel_index(steps.argmax(), steps.shape)
            assert (u, v) == pytest.approx(found.grasps[0].pixel, abs=1.5)
            middle = np.mean(outline["strips"][0][:4], axis=0)
            assert middle == pytest.approx(found.grasps[0].pixel, abs=1e-3)


def test_an_image_that_arrives_late_is_recorded_at_its_time_of_capture(tmp_path: Path) -> None:
    """The robot moves on meanwhile: camera, image and grasps stay where and when they were."""
    late = []
    for snapshot in samples.run(TICKS):
        if snapshot.frame is not None:
            moved = snapshot.frame.oTc.copy()
            moved.translation -= [0.02, 0.0, 0.0]
            frame = replace(snapshot.frame, oTc=moved, stamp=snapshot.stamp - LATENCY)
            snapshot = replace(snapshot, frame=frame)
        late.append(snapshot)
    path = record(tmp_path / "late.rrd", late)
    before, *camera = poses(path, "world/camera")
    assert before["tick"] == 0, "where an image would be taken"
    drawn = [rows(path, f"/world/camera/{entity}") for entity in ("depth", "quality", "grasps")]
    for entity in (*drawn, camera):
        assert [row["tick"] for row in entity] == list(range(170, 300, 20)), "when they arrived"
        for row in entity:
            assert row["t"] == pytest.approx(late[row["tick"]].stamp - LATENCY, abs=1e-6)
    for row in camera:
        place = late[row["tick"]].frame.oTc.translation
        np.testing.assert_allclose(row["translation"][0], place, atol=1e-5)
    hand = poses(path, "world/robot/hand")
    assert all(row["t"] == pytest.approx(late[row["tick"]].stamp, abs=1e-6) for row in hand)


@pytest.mark.parametrize("place", ["missing/x.rrd", ""])
def test_a_file_that_cannot_be_written_is_reported_at_once(tmp_path: Path, place: str) -> None:
    with pytest.raises(RecorderError, match=r"cannot write the recording .*choose a folder"):
        recorder(tmp_path / place)


def test_an_error_in_the_writer_is_reported_once_and_spares_the_run(tmp_path: Path) -> None:
    made = recorder(tmp_path / "x.rrd")
    snapshot = samples.snapshot(0)
    broken = replace(snapshot, state=replace(snapshot.state, q=snapshot.state.q[:3]))
    for tick in range(1200):
        state = replace((broken if tick == 150 else snapshot).state, stamp=tick * 0.02)
        made.record(replace(snapshot, tick=tick, state=state))
    with pytest.raises(RecorderError, match=r"x\.rrd: the recording ends early"):
        made.close()
    made.close()
    assert len(rows(tmp_path / "x.rrd", "/signals/tick")) < 200
