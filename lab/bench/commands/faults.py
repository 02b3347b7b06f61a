"""`bench faults`: a task with every fault in every phase."""

from dataclasses import asdict
from typing import Annotated

import typer

from lab.bench.commands.options import (
    Json,
    Seeds,
    check_writable,
    chosen,
    seed_range,
    show,
    write_json,
)

Names = Annotated[list[str] | None, typer.Option(help="Only this one; may be repeated.")]


def faults(
    faults: Names = None,
    phases: Names = None,
    seeds: Seeds = "1-1",
    quick: Annotated[
        bool, typer.Option("--quick", help="A few faults in two phases, in some seconds.")
    ] = False,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    json: Json = None,
) -> None:
    """Inject every fault in every phase of a task; the simulated world is the judge."""
    from app.core import PHASES
    from lab.bench import faults as bench
    from lab.bench.fault_matrix import FAULTS, QUICK, QUICK_PHASES
    from lab.shared import progress, run_in_order

    check_writable(json)
    if quick:
        faults, phases = faults or list(QUICK), phases or list(QUICK_PHASES)
    rows = chosen("--faults", faults, [fault.name for fault in FAULTS])
    cells = bench.cells(rows, chosen("--phases", phases, PHASES), seed_range(seeds))
    with progress("faults", len(cells)) as advance:
        results = run_in_order(
            bench.run_cell,
            cells,
            lambda one: advance(one.wrong_success or one.hang or one.crash),
            workers=workers,
        )
    show(bench.faults_table(results), *bench.faults_notes(results))
    write_json(json, {"cells": [asdict(one) for one in results]})
