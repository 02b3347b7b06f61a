"""Publishes messages in ROS 2 over loopback, from a process of its own."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from hw.clock import stopwatch
from hw.robot import HardwareError
from hw.ros2.carrier import COMMAND, Route, rings
from hw.ros2.part import carrier

_HOLDS = 1.0  # a message that has waited for longer is not sent [s]
_REST = 0.1  # time for the process to send the last messages [s]


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
