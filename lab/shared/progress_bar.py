"""Progress of long work, on standard error."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from app.terminal import Terminal

_LINES = 10


@contextmanager
def progress(name: str, total: int) -> Iterator[Callable[[bool], None]]:
    """A progress bar in a terminal; elsewhere a line for every tenth of the work.

    Yields a function to call after each item, with whether it failed.
    """
    console = Terminal(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]} failed"),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(name, total=total, failed=0)
        done = failures = 0

        def advance(failed: bool) -> None:
            nonlocal done, failures
            failures += failed
            done += 1
            bar.update(task, completed=done, failed=failures)
            if not console.is_terminal and done * _LINES // total > (done - 1) * _LINES // total:
                console.print(f"{name}: {done} of {total}, {failures} failed")

        yield advance
