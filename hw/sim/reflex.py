"""What stops a part of the robot on a contact, and lets it leave again."""

from __future__ import annotations

from collections.abc import Sequence

from hw.sim.collisions import Contact

_YIELDS = 0.002
"""A contact that was forgiven may become this much deeper while the robot leaves it [m]."""


class Reflex:
    """Trips on every contact that was not forgiven.

    A step that trips it is taken back, so the robot is hardly ever in contact when it is cleared:
    it may move anywhere but there. Where something has come to the robot instead, clearing forgives
    the contact at the depth that it has. It may become shallower, and what is gained is not given
    back; if it becomes deeper, or comes back after it has ended, the reflex trips again.
    """

    def __init__(self) -> None:
        self.tripped_by: Contact | None = None
        """The contact that it tripped on; None while the part may move."""
        self._present: dict[tuple[str, str], float] = {}
        self._forgiven: dict[tuple[str, str], float] = {}

    def feels(self, contacts: Sequence[Contact]) -> bool:
        """Whether any of the contacts is not forgiven."""
        return any(self._is_felt(one) for one in contacts)

    def trip(self, contacts: Sequence[Contact]) -> None:
        """Stop on the deepest of the contacts that are not forgiven, unless it has stopped."""
        if self.tripped_by is None:
            felt = (one for one in contacts if self._is_felt(one))
            self.tripped_by = max(felt, key=lambda one: one.depth)

    def stay(self, contacts: Sequence[Contact]) -> None:
        """A tick has ended with these contacts."""
        self._present = {(one.part, one.thing): one.depth for one in contacts}
        self._forgiven = {
            key: min(depth, self._present[key])
            for key, depth in self._forgiven.items()
            if key in self._present
        }

    def clear(self) -> None:
        """Let the part move again."""
        self.tripped_by = None
        self._forgiven = self._present | self._forgiven

    def _is_felt(self, contact: Contact) -> bool:
        depth = self._forgiven.get((contact.part, contact.thing))
        return depth is None or contact.depth > depth + _YIELDS
