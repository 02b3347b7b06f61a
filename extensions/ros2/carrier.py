"""The process that carries messages between ROS 2 and a part of a robot, or a run; its watchdog.

Messages are bytes here. A command comes with the message that stops the part: that is sent when no
other command has come for `FRESH`, and when the parent has ended.
"""

import os
import socket
import struct
import sys
import time
from typing import Any, NamedTuple

from drivers.processes.child import Parent, hurry, serve, still_alive, stopwatch
from drivers.processes.mailbox import PAGE, Mailbox, open_memory
from drivers.processes.ring import Ring
from extensions.ros2.messages import dds_type, type_hash

FRESH = 0.06  # a command holds for this long [s]
STATUS = struct.Struct("<d16H")  # time [s], matched endpoints of each topic
COMMAND = struct.Struct("<Id")
"""Length of the command [bytes], and how long it holds [s]; what follows the command stops it."""
_STOPS, _STOP_EVERY = 0.5, 0.02  # a stop is repeated for this long, this often [s]
_LOOPBACK = "lo" if sys.platform == "linux" else "lo0"
_BOUND_IF = 25  # IP_BOUND_IF of macOS, which Python does not name
_NAP, _LOOK = 2, 0.1  # waits for messages [ms]; period of the status [s]


class Route(NamedTuple):
    """One topic; `hears` messages or sends them."""

    topic: str  # name in DDS
    type: str
    hears: bool
    slots: int = 8
    size: int = 1 << 14  # longest message [bytes]
    sensor: bool = True  # best effort; otherwise reliable
    latched: bool = False  # with the last message from before


def rings(memory: Any, routes: list[Route]) -> list[Ring]:
    """The shared memory of the topics, behind the page of the status."""
    found, at = [], PAGE
    for route in routes:
        found.append(Ring(memory, at, route.slots, route.size))
        at += _aligned(route)
    return found


def pages(routes: list[Route]) -> int:
    """Size of the shared memory."""
    return 1 + -(-sum(map(_aligned, routes)) // PAGE)


def _aligned(route: Route) -> int:
    return -(-Ring.needs(route.slots, route.size) // PAGE) * PAGE


def configuration(address: str) -> str:
    """Settings of Cyclone DDS: loopback alone, or the network towards an address."""
    interface, multicast = f'name="{_LOOPBACK}" multicast="false"', "false"
    if address:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as towards:
            towards.connect((address, 7400))
            interface, multicast = f'address="{towards.getsockname()[0]}"', "spdp"
    return (
        f"<CycloneDDS><Domain><General><Interfaces><NetworkInterface {interface}/></Interfaces>"
        f"<AllowMulticast>{multicast}</AllowMulticast></General><Discovery>"
        "<ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        f'<Peers><Peer address="{address or "127.0.0.1"}"/></Peers>'
        "</Discovery></Domain></CycloneDDS>"
    )


def stay_on_loopback() -> None:
    """Bind the UDP sockets of this process to loopback: Cyclone DDS hears on every interface."""
    for name in os.listdir("/dev/fd"):
        try:
            one = socket.socket(fileno=os.dup(int(name)))
        except OSError:
            continue  # no socket
        with one:
            if one.family != socket.AF_INET:
                continue
            if hasattr(socket, "SO_BINDTODEVICE"):
                one.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, _LOOPBACK.encode())
            else:
                index = socket.if_nametoindex(_LOOPBACK)
                one.setsockopt(socket.IPPROTO_IP, _BOUND_IF, index)


class Carrier:
    """The endpoints of one part."""

    def __init__(self, domain: int, address: str, routes: list[Route], memory: int) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
        from cyclonedds.domain import Domain, DomainParticipant
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        shared = open_memory(memory)
        self._status = Mailbox(shared, 0, STATUS)
        self._domain = Domain(domain, configuration(address))
        participant = DomainParticipant(domain)
        if not address:
            stay_on_loopback()
        self._waits, self._nap = WaitSet(participant), duration(milliseconds=_NAP)
        self._readers: list[tuple[Any, Ring]] = []
        self._writers: list[_Writer] = []
        self._endpoints: list[Any] = []
        any_state = SampleState.Any | ViewState.Any | InstanceState.Any
        for route, ring in zip(routes, rings(shared, routes), strict=True):
            kind = dds_type(route.type)
            topic, qos = Topic(participant, route.topic, kind), _qos(route)
            if route.hears:
                reader = DataReader(participant, topic, qos=qos)
                self._waits.attach(ReadCondition(reader, any_state))
                self._readers.append((reader, ring))
                self._endpoints.append(reader.get_matched_publications)
            else:
                writer = DataWriter(participant, topic, qos=qos)
                self._writers.append(_Writer(writer, ring, kind))
                self._endpoints.append(writer.get_matched_subscriptions)
        self._looked = 0.0

    def step(self) -> None:
        """Wait for messages for a moment, hand them on, and send commands or stops."""
        self._waits.wait(self._nap)
        now = stopwatch()
        for reader, ring in self._readers:
            for sample in reader.take(N=32):
                if hasattr(sample, "cdr"):
                    ring.put(now, sample.cdr)
        self.send()
        if now - self._looked > _LOOK:
            self._looked = now
            counts = [len(matched()) for matched in self._endpoints]
            self._status.put(now, *counts, *[0] * (16 - len(counts)))

    def send(self, *, is_over: bool = False) -> None:
        """Send new commands; stops where there is none, or in the end."""
        for writer in self._writers:
            writer.send(stopwatch(), is_over)


class _Writer:
    """Sends the commands of one topic, and what stops the part when none has come in time."""

    def __init__(self, writer: Any, ring: Ring, kind: Any) -> None:
        self._writer, self._ring, self._kind = writer, ring, kind
        self._sent = ring.newest()  # not what was before
        self._until, self._stop, self._stopped = 0.0, b"", 0.0  # [s], message, [s]

    def send(self, now: float, is_over: bool) -> None:
        for number, (given, data) in self._ring.since(self._sent):
            length, holds = COMMAND.unpack_from(data)
            end = COMMAND.size + length
            self._sent, self._until, self._stop = number, given + holds, bytes(data[end:])
            if now <= self._until and not is_over:
                self._write(bytes(data[COMMAND.size : end]))
        is_due = is_over or self._until < now < self._until + _STOPS
        if self._stop and is_due and now - self._stopped >= _STOP_EVERY:
            self._stopped = now
            self._write(self._stop)

    def _write(self, cdr: bytes) -> None:
        sample = self._kind()
        sample.cdr = cdr
        self._writer.write(sample)


def _qos(route: Route) -> Any:
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.util import duration

    return Qos(
        Policy.Reliability.BestEffort
        if route.sensor
        else Policy.Reliability.Reliable(duration(milliseconds=100)),
        Policy.Durability.TransientLocal if route.latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(route.slots),
        Policy.Userdata(type_hash(route.type).encode()),
    )


def _work(parent: Parent, what: str, settings: Any, memory: int) -> None:
    routes = [Route(*one) for one in settings["routes"]]
    carrier = Carrier(settings["domain"], settings["address"], routes, memory)
    parent.tell(loaded=True)
    commanded = next((route.topic for route in routes if not route.hears), None)
    if settings["drives"]:
        if commanded:
            parent.claim(f"ROS 2 {what} {commanded}")
        hurry()
    parent.tell(ready=True)
    while parent.commands():
        still_alive()
        carrier.step()
    until = stopwatch() + _STOPS / 2.0
    while stopwatch() < until:
        carrier.send(is_over=True)
        time.sleep(_STOP_EVERY)


def main() -> None:
    """Serve one parent."""
    serve(_work, lambda error: f"{type(error).__name__}: {error}")
