"""Emulators: servers that speak the wire protocols of real machines, and robots made of them."""
