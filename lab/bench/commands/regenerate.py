"""`bench experiments`: the figures of docs/experiments.md once more."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.terminal import Terminal
from lab.bench.commands.options import Json, check_writable, show, write_json


def experiments(
    file: Annotated[Path, typer.Argument(help="The list of experiments.")] = Path(
        "docs/experiments.yaml"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="Small sizes: do all commands work? Judges nothing.")
    ] = False,
    only: Annotated[
        str | None, typer.Option(help="Only the tables whose name contains this.")
    ] = None,
    folder: Annotated[
        Path, typer.Option(help="Where the JSON and the output of each experiment go.")
    ] = Path("runs/experiments"),
    json: Json = None,
) -> None:
    """Run the experiments of the docs once more; compare each figure with its documented value.

    Ends with exit code 1 if a figure has changed.
    """
    from app.commands import refuse
    from config import read_config
    from lab.bench.regenerate import Experiments, regenerate, regenerated_table

    check_writable(json)
    listed = read_config(file, Experiments).experiments
    wanted = [one for one in listed if (only or "").lower() in one.table.lower()]
    if not wanted:
        refuse(f"--only {only}: no table of {file} has this in its name")
    folder.mkdir(parents=True, exist_ok=True)
    done, seconds = [], 0.0
    for number, one in enumerate(wanted, 1):
        figures, duration = regenerate(one, folder, quick)
        done += figures
        seconds += duration
        Terminal(stderr=True).say(f"{number} of {len(wanted)}: {one.table}, {duration:.0f} s")
    changed = 0 if quick else sum(one.changed for one in done)
    summary = f"{len(done)} figures, {changed} changed, {seconds / 60.0:.1f} min"
    show(regenerated_table(done, quick), summary)
    rows = [asdict(one) | {"changed": one.changed and not quick} for one in done]
    about = {"quick": quick, "seconds": seconds, "changed": changed}
    write_json(json, {**about, "results": rows})
    if changed:
        raise typer.Exit(1)
