"""Malformed messages of every topic are skipped and named; what is legal and odd is understood.

The parts are the real ones; what is missing is the process that speaks DDS.
"""

from __future__ import annotations

import time
from copy import deepcopy

import numpy as np
import pytest
from malformed import BYTES, NAN, ROBOT, TOPICS, Topic, joints, odometry, on_map, transforms

from hw import DriverContext, SimClock
from hw.clock import stopwatch
from hw.ros2 import (
    Ros2Base,
    Ros2Laser,
    missing,
)
from hw.ros2.messages import encode, message

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())


class Stand:
    """A part that hears what is put into its memory, on a clock of its own."""

    def __init__(self, topic: Topic, monkeypatch) -> None:
        self.topic, self.clock, self.seconds = topic, SimClock(), 100
        context = DriverContext(robot=ROBOT, clock=self.clock)
        self.part = topic.part(topic.options, context)
        monkeypatch.setattr(self.part._process, "end_of_it", lambda: "")

    def put(self, route: int, one: bytes) -> None:
        self.part._rings[route].put(stopwatch(), one)

    def hear(self, one: bytes | None, *, ticks: int = 6) -> str:
        """One message again and again, and good ones on the other routes; what is wrong then."""
        told = ""
        for _ in range(ticks):
            self.clock.sleep_until(self.clock.now() + 0.1)
            self.part._status.put(stopwatch(), *[1] * 16)
            self.seconds += 1
            for route, good in self.topic.beside.items():
                self.put(route, self.encoded(good, route))
            if one is not None:
                self.put(self.topic.route, one)
            told = self.trouble()
        return told

    def trouble(self) -> str:
        part = self.part
        if part._state is not None if hasattr(part, "_state") else False:
            return "; ".join(fault.text for fault in part.read().faults)
        return part._trouble() or (part._unlocalised() if isinstance(part, Ros2Base) else "")

    def encoded(self, fields: dict, route: int) -> bytes:
        fields = deepcopy(fields)
        if "header" in fields and fields["header"]["stamp"]["sec"] >= 0:
            fields["header"]["stamp"]["sec"] = self.seconds
        return encode(self.part._routes[route].type, fields)


def changed(good: dict, field: str, value: object, kind: str) -> object:
    """A good message with another value in one field."""
    whole = at = message(kind, **deepcopy(good))
    *path, last = field.replace("[", ".[").split(".")
    for step in path:
        at = at[int(step[1:-1])] if step.startswith("[") else getattr(at, step)
    if last.startswith("["):
        at[int(last[1:-1])] = value
    else:
        inner = getattr(at, last)
        setattr(at, last, type(inner)(**value) if isinstance(value, dict) else value)
    return whole


def cases(topic: Topic, part) -> list[tuple[bytes, str]]:
    """Malformed messages, and what is complained about."""
    kind = part._routes[topic.route].type
    made = []
    for field, value, told in topic.wrong:
        one = changed(topic.good, field, value, kind)
        made.append((encode(kind, one), told))
    whole = encode(kind, topic.good)
    cut = [whole[: len(whole) * k // 13] for k in range(1, 10)]
    return made + [(one, "") for one in (*cut, *BYTES)]


@pytest.mark.parametrize("name", TOPICS)
def test_malformed_messages_are_skipped_and_named(name, monkeypatch):
    topic = TOPICS[name]
    source = name.partition(" ")[0]
    count = 0
    for when in ("start", "mid-run"):
        found = cases(topic, Stand(topic, monkeypatch).part)
        count = len(found)
        for wrong, field in found:
            stand = Stand(topic, monkeypatch)
            if when == "mid-run":
                for _ in range(2):
                    stand.seconds += 1
                    stand.hear(stand.encoded(topic.good, topic.route), ticks=1)
                assert not stand.trouble()
                assert not stand.part.complaints
            told = stand.hear(wrong)
            if topic.part is not Ros2Laser:  # which reports no faults
                is_needed = when == "start" or topic.route == 0
                if is_needed:
                    assert source in told, (when, field, told)
                    assert field in told, (when, field, told)
            skipped = " ".join(stand.part.complaints)
            if field not in ("", "name", "transforms"):
                assert source in skipped
                assert field in skipped, (when, field, skipped)
    print(f"{name}: {count} malformed messages")
    assert count >= 40


@pytest.mark.parametrize("velocity", [np.full(8, NAN), np.zeros(0), np.array([NAN] + 7 * [0.0])])
def test_of_a_robot_that_tells_positions_alone_velocities_are_differences(monkeypatch, velocity):
    stand = Stand(TOPICS["/joint_states"], monkeypatch)
    for k in range(2):
        ns = time.time_ns()
        fields = joints() | {"position": np.full(8, 0.1 + 0.02 * k), "velocity": velocity}
        fields["header"]["stamp"] = {"sec": ns // 10**9, "nanosec": ns % 10**9}
        assert stand.hear(encode("sensor_msgs/msg/JointState", fields), ticks=1) == ""
        time.sleep(0.05 * (k == 0))
    qd = stand.part.read().qd
    assert np.ptp(qd) == 0.0
    assert 0.02 < qd[0] < 0.41


@pytest.mark.parametrize("name", ["/joint_states", "/odom", "/scan"])
def test_a_message_without_a_stamp_has_that_of_its_arrival(monkeypatch, name):
    stand = Stand(TOPICS[name], monkeypatch)
    fields = deepcopy(TOPICS[name].good)
    fields["header"]["stamp"] = {"sec": 0, "nanosec": 0}
    for _ in range(5):
        assert stand.hear(encode(stand.part._routes[0].type, fields), ticks=1) == ""
        newest = stand.part.latest() if name == "/scan" else stand.part.read()
        assert stand.clock.now() - newest.stamp < 0.05


def test_joints_of_two_publishers_whose_clocks_differ_are_heard(monkeypatch):
    stand = Stand(TOPICS["/joint_states"], monkeypatch)
    other = joints() | {"name": ["finger"], "position": np.zeros(1), "velocity": np.zeros(1)}
    for k in range(6):
        for fields, ahead in ((other, 600_000_000), (joints(), 0)):
            fields["header"]["stamp"] = {"sec": 100 + k, "nanosec": ahead + 1}
            stand.put(0, encode("sensor_msgs/msg/JointState", fields))
        assert stand.hear(None, ticks=1) == ""


def test_the_old_pose_of_a_latched_topic_is_taken_until_a_new_one_comes(monkeypatch):
    stand = Stand(TOPICS["/amcl_pose"]._replace(route=3), monkeypatch)
    assert stand.hear(stand.encoded(on_map(), 3), ticks=1) == ""
    first = stand.part.read().localised
    stand.put(2, stand.encoded(on_map(), 2))
    newer = stand.part.read().localised
    stand.put(3, stand.encoded(on_map(), 3))
    assert (first is newer, stand.part.read().localised is newer) == (False, True)
    assert newer.source == "/amcl_pose"


def test_a_place_on_the_map_that_is_not_told_is_a_fault_with_its_topic(monkeypatch):
    nothing = TOPICS["/amcl_pose"]
    assert Stand(nothing, monkeypatch).hear(None) == (
        "/amcl_pose has told nothing yet: give the robot its first pose on the map"
    )
    static = Stand(TOPICS["/tf"]._replace(route=3), monkeypatch)
    assert static.hear(static.encoded(transforms(), 3)) == (
        "map -> odom on /tf stands on /tf_static alone, where nothing corrects it"
    )


@pytest.mark.parametrize("is_driving", [True, False])
def test_who_tells_the_place_all_the_time_or_of_a_moving_base_is_missed(monkeypatch, is_driving):
    """AMCL tells nothing of a base that rests."""
    stand, x = Stand(TOPICS["/amcl_pose"], monkeypatch), 0.0
    told = []
    for k in range(80):
        x += 0.05 * is_driving
        good = odometry()
        good["pose"]["pose"]["position"] = {"x": x}
        stand.topic.beside[0] = good
        is_told = k < 40 if is_driving else k < 3
        told.append(stand.hear(stand.encoded(on_map(), 2) if is_told else None, ticks=1))
    if not is_driving:
        assert not any(told)
        return
    assert told.index("/amcl_pose tells nothing any more: look at its node") in range(60, 70)
