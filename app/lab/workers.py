"""The same work on many items, on all cores or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import import_module
from multiprocessing import get_context
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
    """
    batches = [range(i, min(i + batch, len(items))) for i in range(0, len(items), batch)]
    if cluster is not None:
        yield from _on_cluster(work, items, batches, cluster)
    elif workers == 1:
        yield from ((number, work(item)) for number, item in enumerate(items))
    else:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            futures = {
                pool.submit(_batch, work, [items[i] for i in some]): some for some in batches
            }
            for future in as_completed(futures):
                yield from zip(futures[future], future.result(), strict=True)


def _batch(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
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
