"""Findings of the diagnostics, and what drivers need to find them."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from math import isfinite
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np

from robots import RobotDescription

LOOKS, PERIOD = 200, 0.01  # number of readings of a part, and their period [s]

Read = TypeVar("Read")


class Verdict(Enum):
    """Meaning of a finding."""

    GOOD = "good"
    BAD = "bad"
    OPEN = "open"  # not known, or to be decided by the user


@dataclass(frozen=True)
class Finding:
    """One finding."""

    about: str
    verdict: Verdict
    text: str


@runtime_checkable
class Examined(Protocol):
    """A part whose driver tells more of it than its readings."""

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """What is good and bad about it, while it is connected; nothing moves."""


@runtime_checkable
class TellsItsSite(Protocol):
    """A base that tells the settings by which it drives."""

    def site_text(self) -> str:
        """Those settings as YAML, for a file that its options name; raises HardwareError."""


def is_good(about: str, good: bool, text: str) -> Finding:
    """A finding that is good or bad."""
    return Finding(about, Verdict.GOOD if good else Verdict.BAD, text)


def ages(about: str, what: str, age: Callable[[], float], most: float) -> Finding:
    """How old readings are [s], and whether they are younger than `most` [ms]."""
    found = [1000.0 * one for one in watched(age)]
    text = f"{what} are {np.median(found):.0f} ms old in the middle, {max(found):.0f} ms at worst"
    if not isfinite(max(found)):
        text = f"there are no {what}, or not always"
    return is_good(about, max(found) < most, text)


def watched(read: Callable[[], Read]) -> list[Read]:
    """Readings one after the other, for 2 s."""
    seen = []
    for _ in range(LOOKS):
        seen.append(read())
        time.sleep(PERIOD)
    return seen
