"""Publishes the messages of a run in ROS 2, over loopback."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from app.live.feed import Feed
from app.live.ros2.messages import TOPICS, Messages
from app.live.snapshot import ShownRun, Snapshot
from config import UserError
from hw.ros2 import Route, missing, publisher

_PERIOD = 0.02  # interval of sending [s of real time]
_PATIENCE = 5.0  # time to send the rest [s]
_OBEYED = ("/cmd_vel", "/goal_pose")  # by controllers and Nav2: told in a namespace of ours
_NAMES = {topic: f"rt{'/frankie_task' * (topic in _OBEYED)}{topic}" for topic in TOPICS}  # in DDS
_LATCHED = ("/plan", "/rosout", "/scene")  # kept for who comes late
_IMAGE = 1 << 23  # longest [bytes]


@contextmanager
def published(run: ShownRun) -> Iterator[Callable[[Snapshot], None]]:
    """Publish the snapshots that are given to a function, in the domain of `ROS_DOMAIN_ID`.

    The loop never waits for it. Raises UserError: the extra is missing, or that is no domain.
    """
    if reason := missing():
        raise UserError(f"--ros2: {reason}")
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not domain.isdecimal() or int(domain) > 232:
        raise UserError(f"ROS_DOMAIN_ID={domain} is no domain; give a number from 0 to 232")
    routes, messages = [], Messages(run)
    for topic, kind in TOPICS.items():
        room = (3, _IMAGE) if kind.endswith("/Image") else (64, _IMAGE >> 4)
        qos = topic.startswith("/camera/"), topic in _LATCHED
        routes.append(Route(_NAMES[topic], kind, False, *room, *qos))
    with publisher(int(domain), routes) as publish:

        def send(batch: Sequence[Snapshot]) -> None:
            for snapshot in batch:
                for one in messages.of(snapshot):
                    publish(_NAMES[one.topic], one.data)

        feed = Feed(send, lossless=False, period=_PERIOD, name="ros2")
        yield feed.offer
        feed.close(_PATIENCE)
