"""Why the behaviours of a run have failed, from its event log."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from app.core import EVENTS, read_events
from behaviours import LEAVES

_QUESTIONS = ("region_empty",)
"""Leaves that are asked something, besides the conditions."""
_NUMBER = re.compile(r"\d+(\.\d+)?")


def causes(folder: Path) -> dict[str, int]:
    """Causes and how often, the most frequent first; numbers in them are left out.

    Who answers a question, as `region_empty` does, has not failed when the answer is no.
    """
    nodes: list[dict[str, str]] = []
    found: Counter[str] = Counter()
    for event in read_events(folder / EVENTS):
        if event.event == "begin":
            nodes = list(event.fields["nodes"])
        if event.event != "node" or event.fields["status"] != "FAILURE":
            continue
        leaf = LEAVES.get(nodes[event.fields["node"]]["kind"])
        if leaf is not None and not leaf.is_condition and leaf.key not in _QUESTIONS:
            found[f"{leaf.key}: {_NUMBER.sub('#', str(event.fields['message']))}"] += 1
    return dict(found.most_common())
