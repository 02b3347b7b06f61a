"""Encoding of Groot2's monitor protocol, version 2, little-endian.

A request is a header of 6 bytes (protocol, kind, number) and for some kinds a second part. A reply
repeats the header, adds 16 bytes that identify the tree, and may have a second part. An invalid
request is answered by `error` and the reason.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from py_trees.common import Status

PROTOCOL = 2
IDLE_AFTER = 10

_HEADER = struct.Struct("<BcI")
_STATUS = struct.Struct("<HB")
_CODES = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}


class Kind(Enum):
    """Kind of a request."""

    TREE = b"T"
    STATUS = b"S"
    BLACKBOARD = b"B"
    HOOK_INSERT = b"I"
    HOOK_REMOVE = b"R"
    HOOK_REACHED = b"N"
    """Published when a hook acts; not a request."""
    HOOK_UNLOCK = b"U"
    HOOKS_DUMP = b"D"
    HOOKS_REMOVE_ALL = b"A"
    HOOKS_DISABLE = b"X"
    RECORD = b"r"
    TRANSITIONS = b"t"


class Header(NamedTuple):
    """The first part of a request."""

    kind: Kind
    number: int

    def pack(self) -> bytes:
        """The 6 bytes."""
        return _HEADER.pack(PROTOCOL, self.kind.value, self.number)


class Transition(NamedTuple):
    """A change of a node's status."""

    microseconds: int
    uid: int
    code: int


def read_header(data: bytes) -> Header:
    """The header of a request.

    Raises:
        ValueError: it is malformed; the text is that of BehaviorTree.CPP.
    """
    if len(data) != _HEADER.size:
        raise ValueError("wrong request header")
    _, letter, number = _HEADER.unpack(data)
    try:
        return Header(Kind(letter), number)
    except ValueError as error:
        raise ValueError("Request not recognized") from error


def code(status: Status, before: int = 0) -> int:
    """A status as a byte; that of an idle node includes its previous status."""
    if status is not Status.INVALID:
        return _CODES[status]
    return before if before >= IDLE_AFTER or before == 0 else IDLE_AFTER + before


def pack_statuses(codes: Iterable[int]) -> bytes:
    """3 bytes per node: number from 1 in preorder, status."""
    return b"".join(_STATUS.pack(uid, status) for uid, status in enumerate(codes, start=1))


def pack_transitions(transitions: Iterable[Transition]) -> bytes:
    """9 bytes each: 6 of the time, 2 of the node, 1 of the status."""
    return b"".join(
        t.microseconds.to_bytes(6, "little") + _STATUS.pack(t.uid, t.code) for t in transitions
    )
