"""Findings of the diagnostics."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


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
