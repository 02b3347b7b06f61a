"""`bench faults`, `bench signals` and `bench soak`: what becomes of a task when things go wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import refuse
from lab.commands.options import Json, check_writable, console, seed_range, write_json

if TYPE_CHECKING:
    from lab import bench

Names = Annotated[list[str] | None, typer.Option(help="Only this one; may be repeated.")]
Seeds = Annotated[str, typer.Option(help="First and last seed.", metavar="A-B")]


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
    """Let everything go wrong in every phase of a task; judge what the robot did by the truth."""
    from lab import bench
    from lab.shared import progress

    check_writable(json)
    rows, columns = faults or [], phases or []
    if quick:
        rows, columns = rows or list(bench.QUICK), columns or list(bench.QUICK_PHASES)
    cells = bench.cells(rows, columns, seed_range(seeds))
    results: dict[bench.Cell, bench.CellResult] = {}
    with progress("faults", len(cells)) as advance:

        def done(result: bench.CellResult) -> None:
            cell = bench.Cell(trouble=result.trouble, phase=result.phase, seed=result.seed)
            results[cell] = result
            advance(result.wrong_success or result.hang or result.crash)

        bench.run_cells(cells, workers, done)
    ordered = [results[cell] for cell in cells]
    out = console()
    out.print(bench.faults_table(ordered))
    for line in bench.faults_notes(ordered):
        out.print(line, highlight=False, markup=False, soft_wrap=True)
    write_json(json, bench.faults_json(ordered))


def signals(
    count: Annotated[int, typer.Option(help="Of each signal and speed.", min=1)] = 50,
    kinds: Names = None,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    json: Json = None,
) -> None:
    """Interrupt, kill and suspend runs at random moments, and judge what they leave."""
    from lab import bench
    from lab.shared import progress

    check_writable(json)
    chosen = [kind for kind in bench.KINDS if kinds is None or kind in kinds]
    if not chosen:
        refuse(f"--kinds {', '.join(kinds or [])}: choose from {', '.join(bench.KINDS)}")
    cases = bench.signal_cases(chosen, bench.SPEEDS, count)
    with progress("signals", len(cases)) as advance:
        results = bench.run_signals(
            cases, lambda result: advance(not result.is_expected or not result.is_readable), workers
        )
    console().print(bench.signals_table(results))
    write_json(json, bench.signals_json(results))


def soak(
    hours: Annotated[float, typer.Option(help="Simulated hours.", min=0.05)] = 8.0,
    seed: Annotated[int, typer.Option(help="Of objects, noise and faults.", min=0)] = 0,
    json: Json = None,
) -> None:
    """Carry objects to and fro for hours, with a random fault every minute."""
    from lab import bench
    from lab.shared import progress

    check_writable(json)
    minutes = max(1, round(60.0 * hours))
    with progress("simulated minutes", minutes) as advance:
        counted = 0

        def show(soak: bench.Soak) -> None:
            nonlocal counted
            if counted < minutes and 60.0 * soak.hours >= counted:
                counted += 1
                advance(False)

        result = bench.run_soak(hours, seed, show)
    console().print(bench.soak_table(result))
    write_json(json, bench.soak_json(result))
