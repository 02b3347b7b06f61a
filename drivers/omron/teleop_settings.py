"""The section "Teleop settings" of the base, as its text interface tells it."""

from drivers.omron.site import Site

TELEOP = "Teleop settings"  # the section with the full-scale values of `ratioDrive`
TIMEOUT = "Timeout"  # without a `ratioDrive` for so long the base stops [s]; 0: never
Values = dict[str, float | str]

_KEYS = {
    "FullThrottleForwards": ("forward", 1e3),
    "FullThrottleBackwards": ("reverse", 1e3),
    "RotAtStopped": ("turn_deg", 1.0),
    "RotAtFullForwards": ("turn_at_forward_deg", 1.0),
    "RotAtFullBackwards": ("turn_at_reverse_deg", 1.0),
    "TransDeadZone": ("dead_translation", 1.0),
    "RotDeadZone": ("dead_rotation", 1.0),
}
"""Keys of `Site`, and of what each of them is one."""


def site_of(values: Values, default: Site) -> Site:
    """The site of the section `TELEOP`; values that are missing or 0 are those of the default."""
    given = {
        key: one / unit
        for name, (key, unit) in _KEYS.items()
        if isinstance(one := values.get(name), float) and (one or key.startswith("dead"))
    }
    return default.model_copy(update=given)
