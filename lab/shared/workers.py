"""The same work on many items, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from multiprocessing.synchronize import Event
from signal import SIGTERM, signal
from threading import current_thread, main_thread
from types import FrameType
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

_BATCH = 5
"""Items sent to a process at once."""


def run_all(
    work: Callable[[T], R], items: Sequence[T], *, workers: int = 1, batch: int = _BATCH
) -> Iterator[tuple[int, R]]:
    """Do the same work on every item.

    Args:
        work: a function at module level, so that other processes can import it.
        items: arguments of the work.
        workers: number of processes; 1 is this one.
        batch: items sent to a process at once; 1 where each takes long.

    Yields:
        The index of an item and its result, in the order of completion.

    Raises:
        KeyboardInterrupt: the process was asked to terminate; the workers end as well.
    """
    if workers == 1:
        yield from ((number, work(item)) for number, item in enumerate(items))
        return
    batches = [range(i, min(i + batch, len(items))) for i in range(0, len(items), batch)]
    context = get_context("spawn")
    cancelled = context.Event()
    with (
        ProcessPoolExecutor(
            workers, mp_context=context, initializer=_begin, initargs=(cancelled,)
        ) as pool,
        _terminated(),
    ):
        futures = {pool.submit(_batch, work, [items[i] for i in some]): some for some in batches}
        try:
            for future in as_completed(futures):
                yield from zip(futures[future], future.result(), strict=True)
        except BaseException:
            cancelled.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def run_in_order(
    work: Callable[[T], R],
    items: Sequence[T],
    done: Callable[[R], None] = lambda result: None,
    *,
    workers: int = 1,
    batch: int = _BATCH,
) -> list[R]:
    """The results of `run_all` in the order of the items; `done` gets each as it is completed."""
    results: dict[int, R] = {}
    for number, result in run_all(work, items, workers=workers, batch=batch):
        results[number] = result
        done(result)
    return [results[number] for number in range(len(items))]


@contextmanager
def _terminated() -> Iterator[None]:
    """Pass SIGTERM on to the workers and treat it as Ctrl-C; only the main thread can."""
    if current_thread() is not main_thread():
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        for process in active_children():
            process.terminate()
        raise KeyboardInterrupt

    before = signal(SIGTERM, end)
    try:
        yield
    finally:
        signal(SIGTERM, before)


_cancelled: Event | None = None
"""In a worker: whether nobody waits for results any longer."""


def _begin(cancelled: Event) -> None:
    global _cancelled
    _cancelled = cancelled


def _batch(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    if _cancelled is not None and _cancelled.is_set():  # the pool cannot recall this batch
        return []
    return [work(item) for item in items]
