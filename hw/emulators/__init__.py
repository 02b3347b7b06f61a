"""Emulators: servers that speak the wire protocols of the real machines, for drivers to prove."""
