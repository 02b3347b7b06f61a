"""Handshake of ArNetworking, and its requests, whose numbers change with every start [verified]."""

from dataclasses import dataclass, field
from enum import IntEnum
from hashlib import md5
from typing import NamedTuple

from drivers.omron.packet import Fields, Packet, encode, text_field

PROTOCOLS = ("5MTX", "6MTX", "D6MTX")  # that real bases were seen to announce [reported]


class FromServer(IntEnum):
    """Commands of the server."""

    SHUTDOWN = 1
    INTRODUCTION = 2
    CONNECTED = 5
    REJECTED = 6
    LIST = 129
    ARGUMENTS = 131
    GROUPS = 133


class FromClient(IntEnum):
    """Commands of the client."""

    SHUTDOWN = 1
    INTRODUCTION = 2
    TCP_ONLY = 5
    REQUEST = 129


_REASONS = {
    1: "it refuses the user or the password; check both in MobilePlanner",
    2: "it wants its clients at a central server",
    3: "it holds our protocol for the wrong one",
    4: "it refuses our protocol version",
    5: "it has too many clients already; close MobilePlanner or another program",
    6: "it wants another type of client",
}
"""Of REJECTED, by number."""


class Greeting(NamedTuple):
    """First message of the server."""

    password_key: str  # the password is hashed with it; another one in each connection
    protocol: str  # protocol version


def read_greeting(packet: Packet) -> Greeting:
    """Decode an INTRODUCTION."""
    fields = Fields(packet.payload)
    fields.text()  # version, "alpha"
    fields.integers("HII")  # UDP port and keys
    return Greeting(password_key=fields.text(), protocol=fields.text())


def introduction(greeting: Greeting, user: str, password: str) -> bytes:
    """The frames that answer a greeting: who we are, and that we want no UDP."""
    payload = (
        bytes(2)  # no UDP port
        + text_field(user)
        + md5((greeting.password_key + password).encode("latin-1")).digest()
        + text_field(greeting.protocol)
        + bytes(1)  # type of client: unspecified
    )
    return encode(FromClient.INTRODUCTION, payload) + encode(FromClient.TCP_ONLY)


def read_rejection(packet: Packet) -> str:
    """The reason of a rejection, as a message."""
    fields = Fields(packet.payload)
    number = fields.integer("h")
    text = fields.text() if fields.remaining else ""
    reason = _REASONS.get(number, f"it gives reason {number}")
    return f"{reason} ({text})" if text else reason


@dataclass
class Catalogue:
    """The requests that the account may use, by name."""

    numbers: dict[str, int] = field(default_factory=dict)
    arguments: dict[int, tuple[str, str]] = field(default_factory=dict)
    """By number: arguments and reply of the request, in words."""
    is_complete: bool = False  # whether the last list, that of the access groups, has come

    def take(self, packet: Packet) -> bool:
        """Learn from a packet; whether it was one of a list."""
        if packet.command not in (FromServer.LIST, FromServer.ARGUMENTS, FromServer.GROUPS):
            return False
        fields = Fields(packet.payload)
        for _ in range(fields.integer("H")):
            number, first, second = fields.integer("H"), fields.text(), fields.text()
            match packet.command:
                case FromServer.LIST:
                    self.numbers[first] = number
                case FromServer.ARGUMENTS:
                    self.arguments[number] = (first, second)
                case _:
                    self.is_complete = True
        return True

    def has(self, *names: str) -> bool:
        """Whether all of these are offered."""
        return all(name in self.numbers for name in names)

    def command(self, name: str, payload: bytes = b"") -> bytes:
        """The frame that requests something once, or commands it."""
        return encode(self.numbers[name], payload)

    def request(self, name: str, interval: float | None) -> bytes:
        """The frame that requests something every `interval` [s], or (None) on change."""
        milliseconds = -1 if interval is None else round(interval * 1000.0)
        payload = self.numbers[name].to_bytes(2, "little")
        return encode(FromClient.REQUEST, payload + milliseconds.to_bytes(4, "little", signed=True))
