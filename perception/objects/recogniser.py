"""Recognisers name the class of an object; packages may offer more of them.

A recogniser is a class without arguments, offered as an entry point of `frankie_task.recognisers`.
A package is imported only for a class that the shipped recogniser does not know, and a broken one
breaks only the tasks that ask for such a class.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import metadata
from typing import Protocol

from config import PluginError, entries, imported
from perception.frame import ColourFrame
from perception.objects.detected_object import DetectedObjects

ENTRY_POINTS = "frankie_task.recognisers"
PATIENCE = 20.0  # for the import of a package [s]
OVERLAP = 0.5  # smallest intersection over union of the boxes of a label and its object

Box = tuple[int, int, int, int]  # left, top, right and bottom in the image, inclusive [px]


class RecogniserError(Exception):
    """A recogniser failed; the text says which, and why."""


@dataclass(frozen=True, kw_only=True)
class Labelled:
    """A part of the image, and its class."""

    kind: str
    box: Box
    score: float  # confidence, 0 to 1


class Recogniser(Protocol):
    """Recognises some classes of objects."""

    @property
    def kinds(self) -> Sequence[str]:
        """The classes, as words that a task uses."""

    def recognise(self, frame: ColourFrame, objects: DetectedObjects) -> Sequence[Labelled]:
        """Labels of an image, by its depth, its colours if any, or the objects segmented in it."""


@dataclass(frozen=True, kw_only=True)
class KnownClasses:
    """All classes that this installation knows."""

    recognisers: Mapping[str, tuple[str, Recogniser]]
    """By the class: name of the recogniser, and it. The first that offers a class is asked."""
    problems: tuple[str, ...] = ()  # of packages that cannot be used, a line each


def labelled(
    frame: ColourFrame, objects: DetectedObjects, name: str, recogniser: Recogniser
) -> DetectedObjects:
    """The objects with their classes by a recogniser; `name` is for messages.

    Raises:
        RecogniserError: the recogniser raised an exception, or answered something else than labels.
    """
    try:
        labels = [_checked(label) for label in recogniser.recognise(frame, objects)]
    except Exception as error:  # of a package that anybody may have written
        why = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise RecogniserError(f"recogniser `{name}` failed: {why}") from error
    kinds = (
        max(
            (label for label in labels if _shared(label.box, one.box) >= OVERLAP),
            key=lambda label: label.score,
            default=None,
        )
        for one in objects
    )
    return DetectedObjects(
        replace(one, kind=label.kind if label else "")
        for one, label in zip(objects, kinds, strict=True)
    )


def _checked(label: Labelled) -> Labelled:
    left, top, right, bottom = map(float, label.box)
    if not (isinstance(label.kind, str) and 0.0 <= label.score <= 1.0):
        raise ValueError(f"a label has a kind and a score from 0 to 1, not {label!r}")
    if not (left <= right and top <= bottom):
        raise ValueError(f"a box is left, top, right, bottom, not {label.box!r}")
    return label


def _shared(one: Box, other: Box) -> float:
    """Intersection over union of two boxes."""

    def area(left: int, top: int, right: int, bottom: int) -> int:
        return max(0, right - left + 1) * max(0, bottom - top + 1)

    both = area(
        max(one[0], other[0]), max(one[1], other[1]), min(one[2], other[2]), min(one[3], other[3])
    )
    return both / (area(*one) + area(*other) - both)


def installed(shipped: Mapping[str, Recogniser], wanted: str) -> KnownClasses:
    """Known classes; packages are imported only if the shipped recognisers do not know `wanted`."""
    recognisers = {kind: (name, one) for name, one in shipped.items() for kind in one.kinds}
    problems: list[str] = []
    for entry in [] if wanted in recognisers else entries(ENTRY_POINTS):
        offered = _offered(entry)
        if isinstance(offered, str):
            problems.append(offered)
        else:
            recognisers = {kind: (entry.name, offered) for kind in offered.kinds} | recognisers
    return KnownClasses(recognisers=recognisers, problems=tuple(problems))


@cache
def _offered(entry: metadata.EntryPoint) -> Recogniser | str:
    """The recogniser of an entry point, made once in a process; or what is wrong with it."""
    try:
        made = imported(entry, PATIENCE)
        recogniser: Recogniser = made() if isinstance(made, type) else made  # type: ignore[assignment]
        words = list(recogniser.kinds)
        if not words or not all(isinstance(word, str) and word for word in words):
            raise PluginError("its `kinds` are no words")
        if not callable(recogniser.recognise):
            raise PluginError("its `recognise` is no method")
    except Exception as error:  # of a package that anybody may have written
        why = str(error) if isinstance(error, PluginError) else f"{type(error).__name__}: {error}"
        return (
            f"recogniser `{entry.name}` of `{entry.value}` cannot be used: "
            f"{' '.join(why.split())[:200]}; fix or uninstall its package"
        )
    return recogniser
