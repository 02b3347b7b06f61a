"""`--watch`: restarts a task when one of its files is saved."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path

from app.core.launch import run_task
from app.core.outcome import End
from app.core.run_options import RunOptions
from app.core.summary import Result
from app.live import PageServer
from hw import WallClock
from trees.language import TaskFileError, load

_POLL_PERIOD = 0.2
"""Interval of looking for a saved file while nothing runs [s]."""


class Saved:
    """Detects that files are written, replaced, removed or appear."""

    def __init__(self, paths: Iterable[Path]) -> None:
        self._paths = tuple(paths)
        self._before = [_stamp(path) for path in self._paths]

    def __call__(self) -> bool:
        """Whether anything has changed since this object was made."""
        return [_stamp(path) for path in self._paths] != self._before


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def again_on_save(
    tree: Path,
    overrides: Mapping[str, str],
    places: Path | None,
    *,
    act: Callable[[Saved], bool],
    say: Callable[[str], None],
    stopped: Callable[[], bool] = lambda: False,
) -> None:
    """Call `act` with a task each time it is saved, until a person stops it.

    A file with mistakes is reported, and the next save is awaited.

    Args:
        tree: the task.
        overrides: values of its parameters, as texts.
        places: a file of poses and regions.
        act: gets the detector of the next save; returns whether to end.
        say: prints a line.
        stopped: asked between two saves whether to end.

    Raises:
        UserError: bad input other than the task.
    """
    files, site = {tree}, [] if places is None else [places]
    clock = WallClock()
    try:
        while True:
            saved = Saved([*files, *site])
            try:
                files = set(load(tree, overrides=overrides, places=places).files)
                saved = Saved([*files, *site])
                if act(saved):
                    return
            except TaskFileError as error:
                say(str(error))
                files |= {mistake.path for mistake in error.diagnostics}
            next_is = "saved, starts anew" if saved() else "save it to run it again; Ctrl-C ends"
            say(f"{tree}: {next_is}")
            while not saved():
                if stopped():
                    return
                clock.sleep_until(clock.now() + _POLL_PERIOD)
    except KeyboardInterrupt:  # between two runs; in a run the session takes it
        return


def run_on_save(
    options: RunOptions,
    *,
    finished: Callable[[Result], str],
    say: Callable[[str], None],
) -> Result | None:
    """Run a task, and again in a fresh scene each time it is saved, until a person stops it.

    A save brings a moving robot to rest before the task restarts. The control page stays the same;
    `finished` returns the explanation of a run for it. Returns the last run; None if the task could
    not run at all.

    Raises:
        UserError: bad input other than the task; nothing moves.
    """
    results: list[Result] = []
    control = options.control
    page = PageServer(control.page_port, again=True) if control.page else nullcontext()
    with page as server:

        def stopped() -> bool:
            return server is not None and server.stopped

        def act(saved: Saved) -> bool:
            result = run_task(options, interrupted=saved, finished=finished, page_server=server)
            results.append(result)
            return stopped() or (result.outcome.end is End.INTERRUPTED and not saved())

        again_on_save(
            options.tree, options.parameters, options.places, act=act, say=say, stopped=stopped
        )
        if server is not None:
            server.farewell()
    return results[-1] if results else None
