"""`frankie-task export`: a task for BehaviorTree.CPP and Groot2, or runs for learning."""

from pathlib import Path
from typing import Annotated

import typer

from app.commands import find_tree, refuse, write

Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="A file, instead of the screen.")
]


def export(
    names: Annotated[list[str], typer.Argument(help="A task; with --lerobot runs.")],
    output: Output = None,
    lerobot: Annotated[
        Path | None, typer.Option(help="Write a LeRobotDataset of runs into this new folder.")
    ] = None,
    runs: Annotated[Path, typer.Option("--runs", help="Where the runs are.")] = Path("runs"),
    fps: Annotated[
        int, typer.Option(help="With --lerobot: frames a second; divides the control rate.")
    ] = 50,
) -> None:
    """A task as XML for BehaviorTree.CPP 4 and Groot2; or runs for learning.

    With --output, each task file that it includes becomes a file beside it.
    """
    if output is not None and lerobot:
        refuse("--output: runs go where --lerobot says; leave it out")
    if lerobot is not None:
        _export_runs(names, lerobot, runs, fps)
        return
    if len(names) > 1:
        refuse(f"{names[1]}: one at a time becomes a file; add --lerobot DIR to export runs")
    from extensions.export.btcpp import export_files, export_xml
    from trees.language import load

    task = load(find_tree(names[0]), open_parameters=True)
    if output is None:
        typer.echo(export_xml(task), nl=False)
        return
    first, *included = export_files(task).items()
    files = {output.parent / path: text for path, text in included}
    if output in files:
        refuse(f"{output}: a subtree of the task belongs there; choose another name")
    for path, text in {output: first[1], **files}.items():
        _make_folder(path.parent)
        write(path, text)
        typer.echo(f"{path}: written")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        refuse(f"{folder}: cannot be made ({error.strerror}); name a file in another folder")


def _export_runs(names: list[str], folder: Path, runs: Path, fps: int) -> None:
    from app.review import find_run
    from config import counted
    from extensions.export.lerobot import export_lerobot

    done = export_lerobot([find_run(name, runs) for name in names], folder, fps)
    video = "with depth video" if done.has_video else "without video: a run has no pictures"
    typer.echo(
        f"{folder}: {counted(done.episodes, 'episode')} ({done.failed} failed), "
        f"{done.frames} frames, {video}"
    )
