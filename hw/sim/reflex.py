"""What stops a part of the robot on a contact, and lets it leave again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hw.sim.collisions import Contact
from robots import Array

_YIELDS = 0.002
"""While the robot leaves a contact that was forgiven, it may become this much deeper [m]."""


class Reflex:
    """Trips on every contact that is deeper than it yields, and was not forgiven.

    A step that trips it is taken back. Clearing it forgives the contacts that are left, each at the
    depth that it has: the robot may slide along what it touches, and away from it. A forgiven
    contact may become shallower, and what is gained is not given back; if it becomes deeper, or
    comes back after the two were apart, the reflex trips again.
    """

    def __init__(self) -> None:
        self.tripped_by: Contact | None = None
        """The contact that it tripped on; None while the part may move."""
        self._present: dict[tuple[str, str], float] = {}
        self._forgiven: dict[tuple[str, str], float] = {}
        """By how much each is deeper than it yields [m]."""

    @property
    def reason(self) -> str | None:
        """The contact that it tripped on, for people; None while the part may move."""
        return None if self.tripped_by is None else self.tripped_by.text

    @property
    def towards(self) -> Array:
        """(3,) unit vector from the robot to what it tripped on, in the world."""
        return np.zeros(3) if self.tripped_by is None else self.tripped_by.towards

    def feels(self, contacts: Sequence[Contact]) -> bool:
        """Whether any of the contacts is not forgiven."""
        return any(self._is_felt(one) for one in contacts)

    def trip(self, contacts: Sequence[Contact]) -> None:
        """Stop on the deepest of the contacts that are not forgiven, unless it has stopped."""
        if self.tripped_by is None:
            felt = (one for one in contacts if self._is_felt(one))
            self.tripped_by = max(felt, key=lambda one: one.excess)

    def stay(self, contacts: Sequence[Contact]) -> None:
        """A tick has ended with these contacts."""
        self._present = {(one.part, one.thing): max(0.0, one.excess) for one in contacts}
        self._forgiven = {
            key: min(excess, self._present[key])
            for key, excess in self._forgiven.items()
            if key in self._present
        }

    def clear(self) -> None:
        """Let the part move again."""
        self.tripped_by = None
        self._forgiven = self._present | self._forgiven

    def _is_felt(self, contact: Contact) -> bool:
        forgiven = self._forgiven.get((contact.part, contact.thing))
        return contact.excess > (0.0 if forgiven is None else forgiven + _YIELDS)
