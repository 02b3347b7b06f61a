"""Recorded runs in the formats of other projects: LeRobot."""

from app.export.lerobot import USUAL_FPS, ExportError, export_lerobot

__all__ = ["USUAL_FPS", "ExportError", "export_lerobot"]
