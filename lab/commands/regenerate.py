"""`bench experiments`: the figures of docs/experiments.md once more."""

from __future__ import annotations

import json as text
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.terminal import Terminal
from lab.commands.options import Json, check_writable, console, write_json


def experiments(
    file: Annotated[Path, typer.Argument(help="The list of experiments.")] = Path(
        "docs/experiments.yaml"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="Small sizes: do all commands work? Judges nothing.")
    ] = False,
    only: Annotated[
        str | None, typer.Option(help="Only the tables whose name has this in it.")
    ] = None,
    folder: Annotated[
        Path, typer.Option(help="Where the JSON and the output of each experiment go.")
    ] = Path("runs/experiments"),
    json: Json = None,
) -> None:
    """Run the experiments of the docs once more; show what each figure was and what it is.

    Ends with exit code 1 if a figure has changed.
    """
    from app.commands import refuse
    from config import read_config
    from lab import bench
    from lab.shared import machine

    check_writable(json)
    wanted = [
        one
        for one in read_config(file, bench.Experiments).experiments
        if (only or "").lower() in one.table.lower()
    ]
    if not wanted:
        refuse(f"--only {only}: no table of {file} has this in its name")
    folder.mkdir(parents=True, exist_ok=True)
    done, seconds = [], 0.0
    for number, one in enumerate(wanted, 1):
        figures, took = bench.regenerate(one, folder, quick)
        done += figures
        seconds += took
        Terminal(stderr=True).say(f"{number} of {len(wanted)}: {one.table}, {took:.0f} s")
    console().print(bench.regenerated_table(done, quick))
    changed = 0 if quick else sum(one.changed for one in done)
    console().say(f"{len(done)} figures, {changed} changed, {seconds / 60.0:.1f} min")
    about = machine() | {"quick": quick, "seconds": seconds, "changed": changed}
    rows = [asdict(one) | {"changed": one.changed and not quick} for one in done]
    write_json(json, text.dumps(about | {"results": rows}, indent=2))
    if changed:
        raise typer.Exit(1)
