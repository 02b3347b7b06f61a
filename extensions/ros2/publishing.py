"""Publishes the messages of a run in ROS 2 over loopback, from a process of its own."""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

from app.live import Feed, LiveRun, Observer, Snapshot
from config import UserError
from extensions.ros2.carrier import COMMAND, Route, rings
from extensions.ros2.messages import missing
from extensions.ros2.part import carrier
from extensions.ros2.run_messages import TOPICS, Messages
from hw import HardwareError, stopwatch

_HOLDS = 1.0  # a message that has waited for longer is not sent [s]
_REST = 0.1  # time for the process to send the last messages [s]
_PERIOD = 0.02  # interval of sending [s of real time]
_PATIENCE = 5.0  # time to send the rest [s]
_OBEYED = ("/cmd_vel", "/goal_pose")  # by controllers and Nav2: told in a namespace of ours
_NAMES = {topic: f"rt{'/frankie_task' * (topic in _OBEYED)}{topic}" for topic in TOPICS}  # in DDS
_LATCHED = ("/plan", "/rosout", "/scene")  # kept for who comes late
_IMAGE = 1 << 23  # longest [bytes]


@contextmanager
def publisher(domain: int, routes: list[Route]) -> Iterator[Callable[[str, bytes], None]]:
    """A function that publishes CDR on a topic, by one thread only, and never waits.

    Raises HardwareError, as that function does: the process does not start, or has ended.
    """
    settings = {"domain": domain, "address": "", "drives": False}
    process = carrier("publisher", f"domain {domain}", routes, settings)
    topics = [route.topic for route in routes]
    of_topic = dict(zip(topics, rings(process.memory, routes), strict=True))

    def publish(topic: str, cdr: bytes) -> None:
        if ended := process.end_of_it():
            raise HardwareError(ended)
        of_topic[topic].put(stopwatch(), COMMAND.pack(len(cdr), _HOLDS), cdr)

    process.start()
    try:
        yield publish
        threading.Event().wait(_REST)
    finally:
        process.end()


class Publisher(Observer):
    """Publishes a run in the domain of `ROS_DOMAIN_ID`; the loop never waits for it.

    Raises UserError: the extra is missing, that is no domain, or the robot tells it all itself.
    """

    def __init__(self, argument: str, run: LiveRun) -> None:
        if reason := missing():
            raise UserError(f"--with ros2: {reason}")
        if "ros2" in run.drivers:
            raise UserError("--with ros2: this robot tells such topics itself: heard twice")
        domain = argument or os.environ.get("ROS_DOMAIN_ID") or "0"
        if not domain.isdecimal() or int(domain) > 232:
            raise UserError(f"`{domain}` is no domain of ROS 2; give a number from 0 to 232")
        routes = []
        for topic, kind in TOPICS.items():
            room = (3, _IMAGE) if kind.endswith("/Image") else (64, _IMAGE >> 4)
            qos = topic.startswith("/camera/"), topic in _LATCHED
            routes.append(Route(_NAMES[topic], kind, False, *room, *qos))
        self._messages, self._opened = Messages(run.shown), ExitStack()
        self._publish = self._opened.enter_context(publisher(int(domain), routes))
        self._feed = Feed(self._send, lossless=False, period=_PERIOD, name="ros2")

    def show(self, snapshot: Snapshot) -> None:
        """Publish a tick soon."""
        self._feed.offer(snapshot)

    def close(self) -> None:
        """Publish the rest, and end."""
        self._feed.close(_PATIENCE)
        self._opened.close()

    def _send(self, batch: Sequence[Snapshot]) -> None:
        for snapshot in batch:
            for one in self._messages.of(snapshot):
                self._publish(_NAMES[one.topic], one.data)
