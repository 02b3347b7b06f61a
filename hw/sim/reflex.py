"""What stops a part of the robot on a contact, and lets it leave again."""

from __future__ import annotations

from collections.abc import Sequence

from hw.sim.collisions import Contact

_YIELDS = 0.002
"""A contact that was forgiven may become this much deeper while the robot leaves it [m]."""


class Reflex:
    """Trips on every contact that was not forgiven.

    Clearing it forgives the contacts that there are, each at the depth that it has. They may become
    shallower, and what is gained is not given back; a contact that becomes deeper trips again, and
    so does one that comes back after it has ended.
    """

    def __init__(self) -> None:
        self.tripped_by: Contact | None = None
        """The contact that it tripped on; None while the part may move."""
        self._present: dict[tuple[str, str], float] = {}
        self._forgiven: dict[tuple[str, str], float] = {}

    def feel(self, contacts: Sequence[Contact]) -> bool:
        """Whether any of the present contacts is not forgiven, and trips it."""
        self._present = {(one.part, one.thing): one.depth for one in contacts}
        self._forgiven = {
            key: min(depth, self._present[key])
            for key, depth in self._forgiven.items()
            if key in self._present
        }
        felt = [one for one in contacts if one.depth > self._allowed(one)]
        if felt and self.tripped_by is None:
            self.tripped_by = max(felt, key=lambda one: one.depth)
        return bool(felt)

    def clear(self) -> None:
        """Let the part move again."""
        self.tripped_by = None
        self._forgiven = dict(self._present)

    def _allowed(self, contact: Contact) -> float:
        depth = self._forgiven.get((contact.part, contact.thing))
        return 0.0 if depth is None else depth + _YIELDS
