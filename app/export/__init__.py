"""Recorded runs in the formats of other projects: LeRobot."""

from app.export.errors import ExportError
from app.export.lerobot import export_lerobot

__all__ = ["ExportError", "export_lerobot"]
