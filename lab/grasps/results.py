"""Results of an evaluation of grasps, and their tables."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from config import counted
from config.arrays import Array, Mask
from lab.shared import paired_difference, percent

HARD = 60.0  # A contact with more force on the hand is a hard one [N]
HELD, NO_GRASP = "held", "no grasp"  # ends of an attempt: success, and no attempt at all
BIN = 6  # objects in a bin
_LISTED = 20  # kinds of failures at most


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
    hopeless: tuple[int, ...] = ()
    """Numbers of the single scenes in which neither a row nor a random grasp held the object, from
    where this row grasps it."""

    @property
    def feasible(self) -> Mask:
        """(N,) single scenes in which some grasp held, or random grasps were not tried."""
        feasible = np.ones(len(self.singles), dtype=np.bool_)
        feasible[list(self.hopeless)] = False
        return feasible

    @property
    def held(self) -> list[bool]:
        """For every single scene."""
        return [each.held for each in self.singles]

    @property
    def cleared(self) -> Array:
        """(N,) objects cleared of every bin."""
        return np.array([each.cleared for each in self.bins], dtype=float)

    @property
    def attempts(self) -> Array:
        """(N,) attempts in every bin."""
        return np.array([len(each.attempts) for each in self.bins], dtype=float)


@dataclass(frozen=True, kw_only=True)
class GraspEvaluation:
    """Results of several detectors over the same scenes."""

    scenes: tuple[str, ...]  # group and class of each single scene
    rows: tuple[Row, ...]  # all others are compared with the first
    by_chance: int = 0  # random grasps tried in each scene in which no row held the object


def evaluation_tables(evaluation: GraspEvaluation) -> list[Table]:
    """Success rates of all rows with their intervals, and their difference to the first."""
    first = evaluation.rows[0]
    title = f"one object, {len(evaluation.scenes)} scenes, by physics"
    columns = ("held [%]", "no grasp", f"over {HARD:.0f} N", f"{first.name} more [points]")
    single = Table("grasps of", *columns, title=title)
    for row in evaluation.rows:
        single.add_row(row.name, *_single_cells(row, first))
    groups = np.array([scene.partition(",")[0] for scene in evaluation.scenes])
    single.add_section()
    for group in sorted(set(groups)):
        single.add_row(f"{first.name}, {group}", percent(_only(first.held, groups == group)))
    if evaluation.by_chance:
        single.add_section()
        for row in evaluation.rows:
            held = percent(_only(row.held, row.feasible))
            single.add_row(f"{row.name}, where any grasp holds", held)
    if not first.bins:
        return [single]
    title = f"{len(first.bins)} bins of {BIN}, by physics"
    columns = ("cleared [%]", "attempts", f"over {HARD:.0f} N", "cleared an attempt")
    more = (f"{first.name} more [a bin]", "... [an attempt]")
    bins = Table("grasps of", *columns, *more, title=title)
    for row in evaluation.rows:
        bins.add_row(row.name, *_bin_cells(row, first))
    return [single, bins]


def evaluation_notes(evaluation: GraspEvaluation) -> list[str]:
    """The scenes in which no grasp held, and the failures of the first row."""
    first = evaluation.rows[0]
    failed = Counter(
        f"{each.end}: {scene.partition(', ')[2]}"
        for each, scene in zip(first.singles, evaluation.scenes, strict=True)
        if not each.held
    )
    hopeless = Counter(evaluation.scenes[number] for number in first.hopeless)
    return [
        *(
            f"{scene}: in {counted(count, 'scene')} none of {evaluation.by_chance} by chance held"
            for scene, count in hopeless.most_common()
        ),
        *(f"{first.name}, {count} x {end}" for end, count in failed.most_common(_LISTED)),
    ]


def _single_cells(row: Row, first: Row) -> tuple[str, ...]:
    executed = [each for each in row.singles if each.end != NO_GRASP]
    return (
        percent(row.held),
        str(len(row.singles) - len(executed)),
        f"{sum(each.hard for each in executed)} of {len(executed)}",
        "" if row is first else _single_difference(row, first),
    )


def _single_difference(row: Row, first: Row) -> str:
    """Difference of the success rates, in percentage points."""
    one, other = np.array(first.held), np.array(row.held)
    mean, low, high = (100.0 * x for x in paired_difference(one.astype(float), other.astype(float)))
    won, lost = int((one & ~other).sum()), int((other & ~one).sum())
    return f"{mean:+.1f} ({low:+.1f} to {high:+.1f}), {won} won, {lost} lost"


def _bin_cells(row: Row, first: Row) -> tuple[str, ...]:
    executed = [each for one in row.bins for each in one.attempts if each.end != NO_GRASP]
    cleared, attempts = int(row.cleared.sum()), int(row.attempts.sum())
    cells = (
        percent([True] * cleared + [False] * (BIN * len(row.bins) - cleared)),
        str(attempts),
        f"{sum(each.hard for each in executed)} of {len(executed)}",
        f"{cleared / max(attempts, 1):.2f}",
    )
    if row is first:
        return cells
    more = paired_difference(first.cleared, row.cleared)
    each = paired_difference(first.cleared, row.cleared, (first.attempts, row.attempts))
    return (*cells, *(f"{d:+.2f} ({low:+.2f} to {high:+.2f})" for d, low, high in (more, each)))


def _only(held: Sequence[bool], of: Mask) -> list[bool]:
    return [one for one, counts in zip(held, of, strict=True) if counts]
