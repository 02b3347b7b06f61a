"""The matrix of faults as a table, as lines about what is wrong, and as JSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from rich.table import Table

from lab.bench.fault_matrix import TROUBLES
from lab.bench.faults import CellResult
from lab.shared import machine


def faults_table(results: Sequence[CellResult]) -> Table:
    """One row for each fault, summed over phases and seeds, and their sum."""
    table = Table(title=f"faults x phases, on {machine()['machine']}")
    columns = ("fault", "runs", "outcomes", "rest [s]", "resume [s]", "limits", "lost")
    for name in (*columns, "moving", "wrong success", "hang", "crash"):
        table.add_column(name, justify="left" if name in ("fault", "outcomes") else "right")
    names = dict.fromkeys(one.trouble for one in results)
    for name in names:
        table.add_row(name, *_sums([one for one in results if one.trouble == name]))
    table.add_section()
    table.add_row("sum", *_sums(results))
    return table


def faults_notes(results: Sequence[CellResult]) -> list[str]:
    """A line for each cell that is not as it has to be."""
    return [
        f"{one.trouble} in {one.phase}, seed {one.seed}: {', '.join(wrong)} ({one.reason})"
        for one in results
        if (wrong := _wrong(one))
    ]


def faults_json(results: Sequence[CellResult]) -> str:
    """One row for each cell, and the machine."""
    return json.dumps({"about": machine(), "cells": [asdict(one) for one in results]}, indent=1)


def _wrong(one: CellResult) -> list[str]:
    found = {
        "wrong success": one.wrong_success,
        "hang": one.hang,
        "crash": one.crash,
        "limits": one.violations.total > 0,
        "still moving": one.moving and not one.stopped,
        "never entered": one.injected_s is None,
        "never at rest": one.injected_s is not None
        and _stops(one)
        and one.rest_s is None
        and not one.stopped,
    }
    return [name for name, is_so in found.items() if is_so]


def _stops(one: CellResult) -> bool:
    return next(row for row in TROUBLES if row.name == one.trouble).stops


def _sums(results: Sequence[CellResult]) -> list[str]:
    hit = [one for one in results if one.injected_s is not None]
    outcomes = Counter(one.outcome for one in hit)
    return [
        str(len(hit)) if len(hit) == len(results) else f"{len(hit)} of {len(results)}",
        ", ".join(f"{count} {name}" for name, count in outcomes.most_common()),
        _worst([one.rest_s for one in hit]),
        _worst([one.resume_s for one in hit]),
        *(
            str(sum(values))
            for values in (
                [one.violations.total for one in hit],
                [one.lost for one in hit],
                [one.moving and not one.stopped for one in hit],
                [one.wrong_success for one in hit],
                [one.hang for one in hit],
                [one.crash for one in hit],
            )
        ),
    ]


def _worst(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{max(known):.2f}" if known else "-"
