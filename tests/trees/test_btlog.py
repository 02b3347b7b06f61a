"""Logs for Groot2: laid out as BehaviorTree.CPP lays out its own, and true to the run."""

import struct
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from tree_toys import Run

from trees.btcpp import BtLog
from trees.language import nodes_in_order

STATUS = {0: "idle", 1: "running", 2: "success", 3: "failure"}


class Log(NamedTuple):
    """What a `.btlog` says; written after the format, not after the code that writes it."""

    names: dict[int, str]
    tags: dict[int, str]
    began: int
    changes: list[tuple[int, int, str]]
    """Microseconds since then, node, status."""


def read(data: bytes) -> Log:
    assert data[:18] == b"BTCPP4-FileLogger2"
    version, length = struct.unpack_from("<Bi", data, 18)
    assert version == 1
    xml = ElementTree.fromstring(data[23 : 23 + length])
    (began,) = struct.unpack_from("<q", data, 23 + length)
    rest = data[31 + length :]
    assert len(rest) % 9 == 0
    changes = []
    for start in range(0, len(rest), 9):
        microseconds = int.from_bytes(rest[start : start + 6], "little")
        number, status = struct.unpack_from("<HB", rest, start + 6)
        changes.append((microseconds, number, STATUS[status]))
    nodes = [element for element in xml.iter() if element.get("_uid")]
    return Log(
        names={int(node.get("_uid")): node.get("name") for node in nodes},
        tags={int(node.get("_uid")): node.tag for node in nodes},
        began=began,
        changes=changes,
    )


TREE = """
sequence:
  - name: try
    retry: 3
    play: {script: FRS}
  - name: done
    play: {script: RS}
"""


@pytest.fixture
def logged(tmp_path) -> Log:
    run = Run(tmp_path, TREE)
    log = BtLog(nodes_in_order(run.root))
    written = log.head
    for _ in range(4):
        stamp = run.context.clock.now()
        run.ticks(1)
        written += log.changes(stamp)
    return read(written)


def test_nodes_are_numbered_and_every_change_is_there_with_its_time(logged):
    assert logged.names == {1: "sequence", 2: "retry", 3: "try", 4: "done"}
    assert logged.tags == {1: "Sequence", 2: "RetryUntilSuccessful", 3: "play", 4: "play"}
    assert logged.began == 0
    assert logged.changes == [
        (0, 1, "running"),
        (0, 2, "running"),
        (0, 3, "failure"),
        (10_000, 3, "running"),
        (20_000, 2, "success"),
        (20_000, 3, "success"),
        (20_000, 4, "running"),
        (30_000, 1, "success"),
        (30_000, 4, "success"),
    ]
