"""Description of a leaf for task files: key, parameters and outputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour

from config import UserError
from trees.words import Add, Set, ValueType


class LeafError(UserError):
    """A leaf class cannot be used in task files; the text says which and what to change."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a leaf."""

    name: str
    type: ValueType
    required: bool
    default: object = None  # its value if the file gives none; no meaning if `required`
    description: str = ""
    unit: str = ""  # `m/s`, `s`, ...; empty if it has none


@dataclass(frozen=True, kw_only=True)
class Output(Parameter):
    """A result of a leaf; a task file names the key that it is written to."""


@dataclass(frozen=True, kw_only=True)
class LeafType:
    """Description of a leaf; the meaning of most fields stands at `behaviours.Leaf`."""

    key: str
    behaviour: Callable[..., Behaviour]  # its class
    description: str  # the first paragraph of its docstring
    details: str = ""  # the paragraphs after that
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    outputs: Mapping[str, Output] = field(default_factory=dict)
    goes_to: tuple[str, ...] = ()
    surfaces: tuple[str, ...] = ()
    comparable: tuple[str, ...] = ()
    hand_before: str = ""
    hand_after: str = ""
    opens_for: tuple[str, ...] = ()
    lasts: str = ""
    base_rests: bool = False
    near_furniture: str = ""
    counts: str = ""
    moves: bool = False
    needs_robot: bool = True
    names_keys: bool = False  # whether its arguments have the names of keys, which it writes
    validate: Callable[[Mapping[str, object]], str] | None = None
    """See `Leaf.validate`; None if all arguments are compatible."""
    is_condition: bool
    takes_time: bool  # whether it may run for more than a tick
    can_fail: bool = True

    @property
    def described(self) -> tuple[Parameter, ...]:
        """Its parameters and outputs."""
        return *self.parameters.values(), *self.outputs.values()


def _key_writer(node: type[Set], description: str) -> LeafType:
    """A leaf whose arguments have the names of keys."""
    return LeafType(
        key=node.key,
        behaviour=node,
        description=description,
        names_keys=True,
        is_condition=False,
        takes_time=False,
        can_fail=False,
    )


SET = _key_writer(Set, "Writes values to keys: `set: {tries: 0}`; ends at once and cannot fail.")
ADD = _key_writer(Add, "Adds numbers to keys: `add: {tries: 1}`; ends at once and cannot fail.")

OWN_LEAVES: Mapping[str, LeafType] = {leaf.key: leaf for leaf in (SET, ADD)}
"""The leaves that are words of the language."""
