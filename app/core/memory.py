"""Keeping the garbage collector out of the loop's way."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def settled_memory() -> Iterator[None]:
    """What exists by now is not searched for garbage in this context.

    Libraries leave hundreds of thousands of objects, which would be searched again and again: a
    tick takes up to a tenth of a second longer when that happens.
    """
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
