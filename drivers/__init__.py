"""Drivers of real machines; they come in by the door that every package may use."""
