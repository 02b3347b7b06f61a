"""What the judge by physics found: attempts, bins, and all of them in a file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from config import ConfigError
from lab.grasps.closed_loop import HELD
from lab.shared import machine

HARD = 60.0
"""A contact with more force on the hand is a hard one [N]."""
NO_GRASP = "no grasp"
"""End of an attempt that was none."""
BIN = 6
"""Objects in a bin."""


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """What became of the best grasp in one frame."""

    end: str
    """`HELD`, `NO_GRASP`, or where it failed."""
    target_class: str = ""
    """Of the object that was nearest to the grasp."""
    force: float = 0.0
    """The hardest contact on the hand on its way down and until the fingers have closed [N]."""
    quality: float = 0.0
    """That the detector told."""
    kinematic: str = ""
    """What the kinematic judge says of the same grasp: `HELD`, or the reason of the failure."""

    @property
    def held(self) -> bool:
        """Whether it held."""
        return self.end == HELD

    @property
    def hard(self) -> bool:
        """Whether the hand met something with more than `HARD`."""
        return self.force > HARD


@dataclass(frozen=True, kw_only=True)
class BinResult:
    """A bin that was emptied as far as it went."""

    cleared: int
    attempts: tuple[Attempt, ...]
    """Those without a grasp among them."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """What one detector achieved."""

    name: str
    singles: tuple[Attempt, ...]
    bins: tuple[BinResult, ...]

    @property
    def held(self) -> list[bool]:
        """For every single scene."""
        return [each.held for each in self.singles]

    @property
    def cleared(self) -> npt.NDArray[np.float64]:
        """(N,) objects of every bin."""
        return np.array([each.cleared for each in self.bins], dtype=float)

    @property
    def attempts(self) -> npt.NDArray[np.float64]:
        """(N,) in every bin."""
        return np.array([len(each.attempts) for each in self.bins], dtype=float)


@dataclass(frozen=True, kw_only=True)
class PhysicalEvaluation:
    """All rows, over the same scenes."""

    scenes: tuple[str, ...]
    """Group and class of each single scene."""
    rows: tuple[Row, ...]
    """The first is the one that all others are compared with."""
    hopeless: tuple[int, ...] = ()
    """Numbers of the single scenes in which none of `by_chance` grasps held, nor those of a row."""
    by_chance: int = 0
    """Grasps that were tried in each scene in which no row held the object."""

    @property
    def feasible(self) -> npt.NDArray[np.bool_]:
        """(N,) in which single scenes some grasp held, or none was looked for."""
        there = np.ones(len(self.scenes), dtype=np.bool_)
        there[list(self.hopeless)] = False
        return there

    def to_json(self) -> dict[str, object]:
        """For `--json` and, later, for `--against`."""
        return {
            "judge": "physics",
            "scenes": list(self.scenes),
            "rows": [asdict(row) for row in self.rows],
            "hopeless": list(self.hopeless),
            "by_chance": self.by_chance,
            **machine(),
        }


def read_evaluation(path: Path) -> PhysicalEvaluation:
    """What `to_json` wrote to a file; its rows are named after it, too.

    Raises:
        ConfigError: it is no such file.
    """
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
        rows = tuple(
            Row(
                name=f"{row['name']}, {path.stem}",
                singles=tuple(Attempt(**each) for each in row["singles"]),
                bins=tuple(
                    BinResult(
                        cleared=each["cleared"],
                        attempts=tuple(Attempt(**one) for one in each["attempts"]),
                    )
                    for each in row["bins"]
                ),
            )
            for row in figures["rows"]
        )
        return PhysicalEvaluation(scenes=tuple(figures["scenes"]), rows=rows)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"{path}: not figures of `grasp eval --judge physics`") from error
