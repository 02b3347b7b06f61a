"""The same work on many items, on all cores or on a cluster."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import active_children, get_context
from multiprocessing.synchronize import Event
from os import cpu_count
from signal import SIGINT, SIGTERM, set_wakeup_fd, signal
from socket import socketpair
from threading import current_thread, main_thread
from types import FrameType
from typing import TypeVar

from config import UserError, extra

T = TypeVar("T")
R = TypeVar("R")


_BATCH = 5  # items sent to a process at once


def run_all(
    work: Callable[[T], R],
    items: Sequence[T],
    *,
    workers: int | str | None = 1,
    batch: int = _BATCH,
) -> Iterator[tuple[int, R]]:
    """Do the same work on every item.

    `work` is a function that other processes can import. `workers` is the number of processes, of
    which 1 is this one, or the address of a dask.distributed scheduler; None is one per core.
    `batch` items are sent to a process at once. Yields the index of an item and its result, in the
    order of completion. Raises UserError: `distributed` is not installed, or no scheduler
    answers. Raises KeyboardInterrupt: SIGINT or SIGTERM came, even if the work handled it; no other
    item begins, and the workers end as well.
    """
    batches = [range(i, min(i + batch, len(items))) for i in range(0, len(items), batch)]
    if isinstance(workers, str):
        yield from _on_cluster(work, items, batches, workers)
        return
    context = get_context("spawn")
    cancelled = context.Event()
    with _terminated(cancelled):
        if workers == 1:
            with _asked_to_end() as asked:
                for number, item in enumerate(items):
                    result = work(item)
                    if asked():
                        raise KeyboardInterrupt
                    yield number, result
            return
        with ProcessPoolExecutor(
            workers or cpu_count(), mp_context=context, initializer=_begin, initargs=(cancelled,)
        ) as pool:
            futures = {pool.submit(_batch, work, [items[i] for i in b]): b for b in batches}
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
    workers: int | str | None = 1,
    batch: int = _BATCH,
) -> list[R]:
    """The results of `run_all` in the order of the items; `done` gets each as it is completed."""
    results: dict[int, R] = {}
    for number, result in run_all(work, items, workers=workers, batch=batch):
        results[number] = result
        done(result)
    return [results[number] for number in range(len(items))]


@contextmanager
def _terminated(cancelled: Event) -> Iterator[None]:
    """Pass SIGTERM on to the workers and treat it as Ctrl-C; only the main thread can."""
    if current_thread() is not main_thread():
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        cancelled.set()
        for process in active_children():
            process.terminate()
        raise KeyboardInterrupt

    before = signal(SIGTERM, end)
    try:
        yield
    finally:
        signal(SIGTERM, before)


@contextmanager
def _asked_to_end() -> Iterator[Callable[[], bool]]:
    """A function that tells whether SIGINT or SIGTERM has come, whoever handled it."""
    if current_thread() is not main_thread():
        yield lambda: False
        return
    received, sent = socketpair()
    with received, sent:
        for one in (received, sent):
            one.setblocking(False)

        def asked() -> bool:
            try:
                return not {SIGINT, SIGTERM}.isdisjoint(received.recv(4096))
            except BlockingIOError:
                return False

        before = set_wakeup_fd(sent.fileno(), warn_on_full_buffer=False)
        try:
            yield asked
        finally:
            set_wakeup_fd(before)


_cancelled: Event | None = None  # in a worker: whether nobody waits for results any longer


def _begin(cancelled: Event) -> None:
    global _cancelled
    _cancelled = cancelled


def _batch(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    results: list[R] = []
    for item in items:
        if _cancelled is not None and _cancelled.is_set():  # the pool cannot recall this batch
            break
        results.append(work(item))
    return results


def _on_cluster(
    work: Callable[[T], R], items: Sequence[T], batches: Sequence[range], address: str
) -> Iterator[tuple[int, R]]:
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise UserError(f"--cluster needs an extra: {extra('cluster')}") from None
    try:
        client = distributed.Client(address, timeout="10s")
    except (OSError, TimeoutError, ValueError) as error:
        raise UserError(f"--cluster {address}: no scheduler answers there ({error})") from None
    with client:
        futures = {
            client.submit(_batch, work, [items[i] for i in some], pure=False): some
            for some in batches
        }
        for future in distributed.as_completed(futures):
            yield from zip(futures[future], future.result(), strict=True)
