"""How a connection begins: greeting, introduction, verdict, and the names of what can be asked for.

The numbers of requests are handed out anew whenever the robot starts, so they are looked up by name
in every connection [verified].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from hashlib import md5
from typing import NamedTuple

from hw.omron.fields import Fields, text_field
from hw.omron.packet import Packet, encode

PROTOCOLS = ("5MTX", "6MTX", "D6MTX")
"""Names of the protocol versions that real bases were seen to announce [reported]."""


class FromServer(IntEnum):
    """Commands of the server below the numbers of requests."""

    SHUTDOWN = 1
    INTRODUCTION = 2
    CONNECTED = 5
    REJECTED = 6
    LIST = 129
    LIST_SINGLE = 130
    ARGUMENTS = 131
    ARGUMENTS_SINGLE = 132
    GROUPS = 133
    GROUPS_SINGLE = 134


class FromClient(IntEnum):
    """Commands of the client below the numbers of requests."""

    SHUTDOWN = 1
    INTRODUCTION = 2
    TCP_ONLY = 5
    REQUEST = 129
    REQUEST_STOP = 130


REASONS = {
    1: "it refuses the user or the password; check both in MobilePlanner",
    2: "it wants its clients at a central server",
    3: "it holds our protocol for the wrong one",
    4: "it refuses our protocol version",
    5: "it has too many clients already; close MobilePlanner or another program",
    6: "it wants another type of client",
}
"""What REJECTED means, by its number."""


class Greeting(NamedTuple):
    """What the server says first."""

    password_key: str
    """Of this connection; the password is hashed with it."""
    protocol: str
    """The version that it enforces."""


def read_greeting(packet: Packet) -> Greeting:
    """Of an INTRODUCTION.

    Raises:
        LayoutError: it is none.
    """
    fields = Fields(packet.payload)
    fields.text()  # version, "alpha"
    fields.integers("HII")  # UDP port and keys, for those who want UDP
    return Greeting(password_key=fields.text(), protocol=fields.text())


def password_hash(password_key: str, password: str) -> bytes:
    """What stands in for the password (16 bytes); the server's own key is empty [reported]."""
    return md5((password_key + password).encode("latin-1")).digest()


def introduction(greeting: Greeting, user: str, password: str) -> bytes:
    """The frames that answer a greeting: who we are, and that we want no UDP."""
    payload = (
        bytes(2)  # no UDP port
        + text_field(user)
        + password_hash(greeting.password_key, password)
        + text_field(greeting.protocol)
        + bytes(1)  # type of client: unspecified
    )
    return encode(FromClient.INTRODUCTION, payload) + encode(FromClient.TCP_ONLY)


def read_rejection(packet: Packet) -> str:
    """Why, for people."""
    fields = Fields(packet.payload)
    reason = fields.integer("h")
    text = fields.text() if fields.left else ""
    said = REASONS.get(reason, f"it gives reason {reason}")
    return f"{said} ({text})" if text else said


@dataclass(frozen=True, kw_only=True)
class Offer:
    """One thing that can be asked for, as the server describes it."""

    number: int
    description: str


@dataclass
class Catalogue:
    """All that the account may ask for, by name."""

    offers: dict[str, Offer] = field(default_factory=dict)
    arguments: dict[int, tuple[str, str]] = field(default_factory=dict)
    """Of a number: what its request takes and what it returns, in words."""
    groups: dict[int, str] = field(default_factory=dict)
    """Of a number: the access group that may ask for it."""

    def take(self, packet: Packet) -> bool:
        """Learn from a packet; whether it was one of a list.

        Raises:
            LayoutError: it is damaged.
        """
        fields = Fields(packet.payload)
        match packet.command:
            case FromServer.LIST | FromServer.ARGUMENTS | FromServer.GROUPS:
                count = fields.integer("H")
            case FromServer.LIST_SINGLE | FromServer.ARGUMENTS_SINGLE | FromServer.GROUPS_SINGLE:
                count = 1
            case _:
                return False
        for _ in range(count):
            number = fields.integer("H")
            first, second = fields.text(), fields.text()
            match packet.command:
                case FromServer.LIST | FromServer.LIST_SINGLE:
                    self.offers[first] = Offer(number=number, description=second)
                case FromServer.ARGUMENTS | FromServer.ARGUMENTS_SINGLE:
                    self.arguments[number] = (first, second)
                case _:
                    self.groups[number] = first
        return True

    def has(self, *names: str) -> bool:
        """Whether all of these are offered."""
        return all(name in self.offers for name in names)

    def number(self, name: str) -> int | None:
        """Of a name, None where it is not offered."""
        offer = self.offers.get(name)
        return None if offer is None else offer.number

    def command(self, name: str, payload: bytes = b"") -> bytes:
        """The frame that asks for something once, or commands it.

        Raises:
            KeyError: it is not offered.
        """
        return encode(self.offers[name].number, payload)

    def request(self, name: str, interval: float | None) -> bytes:
        """The frame that asks for something again and again [s], or (None) whenever it changes.

        Raises:
            KeyError: it is not offered.
        """
        number = self.offers[name].number.to_bytes(2, "little")
        milliseconds = -1 if interval is None else round(interval * 1000.0)
        payload = number + milliseconds.to_bytes(4, "little", signed=True)
        return encode(FromClient.REQUEST, payload)
