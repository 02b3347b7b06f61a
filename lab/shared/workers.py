"""The same work on many items, on all cores or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import active_children, get_context
from multiprocessing.synchronize import Event
from signal import SIGTERM, signal
from threading import current_thread, main_thread
from types import FrameType
from typing import TypeVar

from config import UserError

T = TypeVar("T")
R = TypeVar("R")

_BATCH = 5
"""Items sent to a process at once."""


class ClusterError(UserError):
    """The cluster cannot be used."""


def run_all(
    work: Callable[[T], R],
    items: Sequence[T],
    *,
    workers: int = 1,
    cluster: str | None = None,
    batch: int = _BATCH,
) -> Iterator[tuple[int, R]]:
    """Do the same work on every item.

    Args:
        work: a function at module level, so that other processes can import it.
        items: arguments of the work.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.
        batch: items sent to a process at once; 1 where each takes long.

    Yields:
        The index of an item and its result, in the order of completion.

    Raises:
        ClusterError: `distributed` is not installed, or no scheduler answers at the address.
        KeyboardInterrupt: the process was told to end; so were the others.
    """
    batches = [range(i, min(i + batch, len(items))) for i in range(0, len(items), batch)]
    if cluster is not None:
        yield from _on_cluster(work, items, batches, cluster)
    elif workers == 1:
        yield from ((number, work(item)) for number, item in enumerate(items))
    else:
        context = get_context("spawn")
        over = context.Event()
        with (
            ProcessPoolExecutor(
                workers, mp_context=context, initializer=_begin, initargs=(over,)
            ) as pool,
            _terminated(),
        ):
            futures = {
                pool.submit(_batch, work, [items[i] for i in some]): some for some in batches
            }
            try:
                for future in as_completed(futures):
                    yield from zip(futures[future], future.result(), strict=True)
            except BaseException:  # nobody waits for the others any longer
                over.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise


@contextmanager
def _terminated() -> Iterator[None]:
    """Pass SIGTERM on to the processes and take it as Ctrl-C; the main thread alone can."""
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


_over: Event | None = None
"""In a process of a pool: whether nobody waits for results any longer."""


def _begin(over: Event) -> None:
    global _over
    _over = over


def _batch(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    if _over is not None and _over.is_set():  # the pool cannot take back what it has handed out
        return []
    return [work(item) for item in items]


def _on_cluster(
    work: Callable[[T], R], items: Sequence[T], batches: Sequence[range], address: str
) -> Iterator[tuple[int, R]]:
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise ClusterError(
            '--cluster needs an extra: pip install "frankie-task[cluster]"'
        ) from None
    try:
        client = distributed.Client(address, timeout="10s")
    except (OSError, TimeoutError, ValueError) as error:
        raise ClusterError(f"--cluster {address}: no scheduler answers there ({error})") from None
    with client:
        futures = {
            client.submit(_batch, work, [items[i] for i in some], pure=False): some
            for some in batches
        }
        for future in distributed.as_completed(futures):
            yield from zip(futures[future], future.result(), strict=True)
