"""What the parts of a robot in ROS 2 share: messages, commands, and why there is silence."""

import threading
from collections.abc import Callable, Iterator, Mapping
from math import inf
from typing import Any

from pydantic import Field

from drivers.processes.mailbox import Mailbox
from drivers.processes.process import DriverProcess
from drivers.processes.timestamps import SensorClock
from extensions.ros2.carrier import COMMAND, FRESH, STATUS, Route, pages, rings
from extensions.ros2.checked_messages import ElsewhereError, stamp_of
from extensions.ros2.messages import decode, encode, missing
from hw import Clock, Fault, FaultKind, HardwareError, RefusedError, epoch, stopwatch
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
    return DriverProcess(
        "extensions.ros2.carrier", what, where, settings, size, _CONNECTING, missing
    )


class Ros2Part:
    """A part of a robot behind a process; the first of its routes must not fall silent.

    Messages come through the `doors` of their routes, which check them; a route without one is not
    checked. What is refused is skipped, and the newest complaint about each route kept.
    """

    _part = "part"
    _needs: tuple[int, ...] = (0,)
    """Routes without which there is no reading; of others than the first one message will do."""

    def __init__(
        self,
        options: Ros2Options,
        clock: Clock,
        routes: list[Route],
        doors: Mapping[int, Callable[[Any], Any]],
    ) -> None:
        self._clock, self._routes, self._silence = clock, routes, options.silence
        self._doors = doors
        self._where = f"domain {options.domain}" + f" at {options.address}" * bool(options.address)
        settings = {"domain": options.domain, "address": options.address, "drives": True}
        self._process = carrier(type(self).__name__, self._where, routes, settings)
        self._status = Mailbox(self._process.memory, 0, STATUS)
        self._rings = rings(self._process.memory, routes)
        self._seen = [0] * len(routes)
        self._last = [-inf] * len(routes)  # stamps of the newest messages, as given
        self._clocks = [SensorClock() for _ in routes]
        self._taken = [-inf] * len(routes)  # when the newest message was taken [s]
        self._delay = 0.0  # from capture to arrival of the newest message of the first route [s]
        self._complaints: dict[int, RefusedError] = {}  # by route, until a message is taken
        self._told: dict[tuple[int, str], str] = {}  # of each route and field the first
        self._hearing, self._telling = threading.Lock(), threading.Lock()

    @property
    def complaints(self) -> tuple[str, ...]:
        """What was refused so far, the first of each topic and field."""
        return tuple(self._told.values())

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
        self._wait(self._trouble)

    def _wait(self, trouble: Callable[[], str]) -> None:
        """Wait until there is no such trouble any more, or HardwareError."""
        until, pause = stopwatch() + _PATIENCE, threading.Event()
        while wrong := trouble():
            if stopwatch() > until:
                raise HardwareError(wrong)
            pause.wait(_POLL)
            self._trouble()  # hears what came meanwhile

    def stop(self) -> None:
        """It does not move."""

    def close(self) -> None:
        """Stop, and end the process."""
        self._process.end()

    def _hear(self) -> None:
        """Take over what came."""
        raise NotImplementedError

    def _new(self, route: int) -> Iterator[tuple[float, Any]]:
        """What the door gives of messages that came since, with stamps on the session's clock [s].

        The stamps are those of their headers, else of the arrival. A message that was overtaken
        by another is left out, as is one that the door refuses.
        """
        door = self._doors.get(route, lambda message: message)
        for number, (arrived, data) in self._rings[route].since(self._seen[route]):
            self._seen[route] = number
            try:
                message = decode(self._routes[route].type, data)
                found = door(message)
                stamp = self._stamp(route, arrived, message)
            except RefusedError as wrong:
                self._complain(route, wrong)
            except Exception as error:  # of bytes that anybody may have sent
                why = f"no {self._routes[route].type} ({type(error).__name__})"
                self._complain(route, RefusedError("a message", f"{len(data)} bytes", why))
            else:
                self._taken[route] = self._clock.now()
                self._complaints.pop(route, None)
                yield stamp, found

    def _complain(self, route: int, wrong: RefusedError) -> None:
        """Keep it, the first in a row of the same; what tells of something else says less."""
        before = self._complaints.get(route)
        is_elsewhere = isinstance(wrong, ElsewhereError)
        if before is None or not (is_elsewhere or before.field == wrong.field):
            self._complaints[route] = wrong
        if not is_elsewhere:
            self._told.setdefault((route, wrong.field), self._about(route, wrong))

    def _about(self, route: int, wrong: RefusedError) -> str:
        return f"{self._topic(route)} tells the {self._part} {wrong}"

    def _stamp(self, route: int, arrived: float, message: Any) -> float:
        age, last = stopwatch() - arrived, self._last[route]
        header = getattr(message, "header", None)
        if header is not None and (given := stamp_of(header)) is not None:
            if last - _OVERTAKEN < given <= last:
                back = f"{last - given:.2f} s before the last: are there two clocks?"
                why = back if given < last else "the same again and again"
                raise ElsewhereError("header.stamp", f"{given:.2f}", why)
            self._last[route] = given
            captured = self._clocks[route].stamp(given, arrived, epoch() - age)
            age = stopwatch() - captured
            self._delay = self._delay if route else arrived - captured
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
            self._hear()
        if ended := self._process.end_of_it():
            return f"the driver of ROS 2 ({self._where}): {ended}"
        status = self._status.get()
        if status is None or stopwatch() - status[0] > _HUNG:
            return f"the driver of ROS 2 ({self._where}) gets no time"
        if wrong := next(filter(None, map(self._missing, self._needs)), ""):
            return wrong
        for number, (route, matched) in enumerate(zip(self._routes, status[1:], strict=False)):
            if not matched and not (route.hears and (route.sensor or route.latched)):
                return f"nobody listens to {self._topic(number)} in {self._where} as {route.type}"
        return ""

    def _topic(self, number: int) -> str:
        return "/" + self._routes[number].topic.partition("/")[2]

    def _missing(self, number: int) -> str:
        """What is wrong with a route that is needed; empty if it tells enough."""
        name, arrival = self._topic(number), self._rings[number].arrival()
        longest = inf if number else self._silence
        if arrival is None or stopwatch() - arrival > longest:
            return f"nobody publishes {name} in {self._where}: look at its node"
        silence = self._clock.now() - self._taken[number]
        if silence <= longest and silence < inf:
            return ""
        wrong = self._complaints.get(number)
        return self._about(number, wrong) if wrong else f"{name} tells nothing of the {self._part}"
