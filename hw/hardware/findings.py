"""What is found of a robot or a computer."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """What a finding means."""

    GOOD = "good"
    BAD = "bad"
    OPEN = "open"
    """Nobody can tell, or a person has to decide."""


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    about: str
    verdict: Verdict
    text: str
