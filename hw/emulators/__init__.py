"""Emulators: servers that speak the wire protocols of the real machines, to test the drivers."""
