"""Recorded runs in the formats of other projects: LeRobot."""

from app.export.lerobot import export_lerobot

__all__ = ["export_lerobot"]
