"""Results of an evaluation of grasps, and their file."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from config import ConfigError
from lab.shared import machine

HARD = 60.0  # A contact with more force on the hand is a hard one [N]
HELD, NO_GRASP = "held", "no grasp"  # ends of an attempt: success, and no attempt at all
BIN = 6  # objects in a bin


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """Result of the best grasp in one frame."""

    end: str  # `HELD`, `NO_GRASP`, or where it failed
    target_class: str = ""  # class of the object nearest to the grasp
    force: float = 0.0
    """Hardest contact on the hand on its way down and until the fingers have closed [N]."""
    quality: float = 0.0  # as estimated by the detector

    @property
    def held(self) -> bool:
        """Whether the grasp held."""
        return self.end == HELD

    @property
    def hard(self) -> bool:
        """Whether there was a contact beyond `HARD`."""
        return self.force > HARD


@dataclass(frozen=True, kw_only=True)
class BinResult:
    """Result of emptying a bin."""

    cleared: int
    attempts: tuple[Attempt, ...]  # frames without a grasp included


@dataclass(frozen=True, kw_only=True)
class Row:
    """Results of one detector."""

    name: str
    singles: tuple[Attempt, ...]
    bins: tuple[BinResult, ...]

    @property
    def held(self) -> list[bool]:
        """For every single scene."""
        return [each.held for each in self.singles]

    @property
    def cleared(self) -> npt.NDArray[np.float64]:
        """(N,) objects cleared of every bin."""
        return np.array([each.cleared for each in self.bins], dtype=float)

    @property
    def attempts(self) -> npt.NDArray[np.float64]:
        """(N,) attempts in every bin."""
        return np.array([len(each.attempts) for each in self.bins], dtype=float)


@dataclass(frozen=True, kw_only=True)
class GraspEvaluation:
    """Results of several detectors over the same scenes."""

    scenes: tuple[str, ...]  # group and class of each single scene
    rows: tuple[Row, ...]  # all others are compared with the first
    hopeless: tuple[int, ...] = ()
    """Numbers of the single scenes in which neither a row nor a random grasp held the object."""
    by_chance: int = 0  # random grasps tried in each scene in which no row held the object

    @property
    def feasible(self) -> npt.NDArray[np.bool_]:
        """(N,) single scenes in which some grasp held, or random grasps were not tried."""
        feasible = np.ones(len(self.scenes), dtype=np.bool_)
        feasible[list(self.hopeless)] = False
        return feasible

    def to_json(self) -> dict[str, object]:
        """For `--json` and, later, for `--against`."""
        return {**asdict(self), **machine()}


def read_evaluation(path: Path) -> GraspEvaluation:
    """Read the file of `--json`; the rows are named after it, too.

    Raises:
        ConfigError: it is no such file.
    """
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
        rows = tuple(
            Row(
                name=f"{row['name']}, {path.stem}",
                singles=_attempts(row["singles"]),
                bins=tuple(
                    BinResult(cleared=each["cleared"], attempts=_attempts(each["attempts"]))
                    for each in row["bins"]
                ),
            )
            for row in figures["rows"]
        )
        return GraspEvaluation(scenes=tuple(figures["scenes"]), rows=rows)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ConfigError(f"{path}: not figures of `grasp eval`") from error


def _attempts(figures: list[dict[str, object]]) -> tuple[Attempt, ...]:
    names = Attempt.__dataclass_fields__
    return tuple(
        Attempt(**{name: value for name, value in each.items() if name in names})  # type: ignore[arg-type]
        for each in figures
    )
