"""What the parts of a robot in ROS 2 share: messages, commands, and why there is silence."""

import threading
from collections.abc import Iterator
from math import inf
from typing import Any

from pydantic import Field

from hw.clock import Clock, epoch, stopwatch
from hw.processes.mailbox import Mailbox
from hw.processes.process import DriverProcess
from hw.processes.timestamps import SensorClock
from hw.robot import HardwareError
from hw.ros2.carrier import COMMAND, FRESH, STATUS, Route, pages, rings
from hw.ros2.messages import decode, encode, missing
from hw.state import Fault, FaultKind
from robots import DriverOptions

_CONNECTING = 20.0  # timeout of the process [s]
_PATIENCE = 5.0  # for the first messages, and for a recovery [s]
_HUNG = 1.0  # without a status for this long the process hangs [s]
_POLL = 0.01  # [s]
_OVERTAKEN = 1.0  # a stamp that is further back is that of a clock that was set [s]


class Ros2Options(DriverOptions):
    """What every part in ROS 2 has."""

    domain: int = Field(default=0, ge=0, le=232)
    address: str = ""  # of the robot's computer; empty: this one, over loopback alone
    namespace: str = ""
    silence: float = Field(default=0.25, ge=0.05, le=2.0)
    """Without a message for this long there is a fault [s]."""

    def name(self, topic: str) -> str:
        """A topic or action with its namespace."""
        return topic if topic.startswith("/") else f"{self.namespace.rstrip('/')}/{topic}"

    def hears(self, topic: str, kind: str, **options: Any) -> Route:
        """A topic to listen to."""
        return Route(f"rt/{self.name(topic).lstrip('/')}", kind, True, **options)

    def tells(self, topic: str, kind: str) -> Route:
        """A topic to publish."""
        return Route(f"rt/{self.name(topic).lstrip('/')}", kind, False, sensor=False)


def carrier(what: str, where: str, routes: list[Route], settings: dict[str, Any]) -> DriverProcess:
    """The process that carries messages; not started yet."""
    settings, size = settings | {"routes": routes}, pages(routes)
    return DriverProcess("hw.ros2.carrier", what, where, settings, size, _CONNECTING, missing)


class Ros2Part:
    """A part of a robot behind a process; the first of its routes must not fall silent."""

    _lacks = ""  # what is wrong if that tells nothing of this part

    def __init__(self, options: Ros2Options, clock: Clock, routes: list[Route]) -> None:
        self._clock, self._routes, self._silence = clock, routes, options.silence
        self._where = f"domain {options.domain}" + f" at {options.address}" * bool(options.address)
        settings = {"domain": options.domain, "address": options.address, "drives": True}
        self._process = carrier(type(self).__name__, self._where, routes, settings)
        self._status = Mailbox(self._process.memory, 0, STATUS)
        self._rings = rings(self._process.memory, routes)
        self._seen = [0] * len(routes)
        self._last = [-inf] * len(routes)  # stamps of the newest messages, as given
        self._clocks = [SensorClock() for _ in routes]
        self._heard = -inf  # when the newest state was heard
        self._hearing, self._telling = threading.Lock(), threading.Lock()

    def connect(self) -> None:
        """Start the process, and wait for the first state; HardwareError: what is missing."""
        self._process.start()
        try:
            self.recover()
        except HardwareError:
            self.close()
            raise

    def recover(self) -> None:
        """Wait until its nodes are back, also in a new process; HardwareError: they are not."""
        if self._process.end_of_it():
            self._process.start()
        until, pause = stopwatch() + _PATIENCE, threading.Event()
        while trouble := self._trouble():
            if stopwatch() > until:
                raise HardwareError(trouble)
            pause.wait(_POLL)

    def stop(self) -> None:
        """It does not move."""

    def close(self) -> None:
        """Stop, and end the process."""
        self._process.end()

    def _hear(self) -> bool:
        """Take over what came; whether there was a new state."""
        raise NotImplementedError

    def _new(self, route: int) -> Iterator[tuple[float, Any]]:
        """Messages that came since, with their stamps on the session's clock [s].

        The stamps are those of their headers, else of the arrival. A message that was overtaken
        by another is left out.
        """
        for number, (arrived, data) in self._rings[route].since(self._seen[route]):
            self._seen[route] = number
            message = self._decoded(self._routes[route], data)
            if (stamp := self._stamp(route, arrived, message)) is not None:
                yield stamp, message

    def _decoded(self, route: Route, data: bytearray) -> Any:
        try:
            return decode(route.type, data)
        except Exception as error:  # of bytes that anybody may have sent
            raise HardwareError(f"{_name(route)} is no {route.type}: {error}") from error

    def _stamp(self, route: int, arrived: float, message: Any) -> float | None:
        age, last = stopwatch() - arrived, self._last[route]
        if (header := getattr(message, "header", None)) is not None:
            given = header.stamp.sec + 1e-9 * header.stamp.nanosec
            if last - _OVERTAKEN < given <= last:
                return None
            self._last[route] = given
            age = stopwatch() - self._clocks[route].stamp(given, arrived, epoch() - age)
        return self._clock.now() - age

    def _publish(self, route: int, message: Any, stop: Any = None, holds: float = FRESH) -> None:
        """Send a message, and `stop` when none has followed it in time."""
        kind = self._routes[route].type
        first, then = encode(kind, message), b"" if stop is None else encode(kind, stop)
        with self._telling:
            self._rings[route].put(stopwatch(), COMMAND.pack(len(first), holds), first, then)

    def _faults(self) -> tuple[Fault, ...]:
        text, kind = self._trouble(), FaultKind.CONNECTION
        return (Fault(kind=kind, text=text, clearable=True),) if text else ()

    def _trouble(self) -> str:
        """Why it cannot be used; empty if it can."""
        with self._hearing:
            if self._hear():
                self._heard = self._clock.now()
        if ended := self._process.end_of_it():
            return f"the driver of ROS 2 ({self._where}): {ended}"
        status = self._status.get()
        if status is None or stopwatch() - status[0] > _HUNG:
            return f"the driver of ROS 2 ({self._where}) gets no time"
        arrival = self._rings[0].arrival()
        if arrival is None or stopwatch() - arrival > self._silence:
            return f"nobody publishes {_name(self._routes[0])} in {self._where}: look at its node"
        for route, matched in zip(self._routes, status[1:], strict=False):
            if not matched and not (route.hears and (route.sensor or route.latched)):
                return f"nobody listens to {_name(route)} in {self._where} as {route.type}"
        return self._lacks if self._clock.now() - self._heard > self._silence else ""


def _name(route: Route) -> str:
    return "/" + route.topic.partition("/")[2]
