"""Tables of an evaluation of grasps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from rich.table import Table

from lab.grasps.results import BIN, HARD, NO_GRASP, GraspEvaluation, Row
from lab.shared import paired_difference, percent

_LISTED = 20  # kinds of failures at most


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
            held = percent(_only(row.held, evaluation.feasible))
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
    hopeless = Counter(evaluation.scenes[number] for number in evaluation.hopeless)
    return [
        *(
            f"{scene}: in {count} scenes none of {evaluation.by_chance} grasps by chance held"
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


def _only(held: Sequence[bool], of: npt.NDArray[np.bool_]) -> list[bool]:
    return [one for one, counts in zip(held, of, strict=True) if counts]
