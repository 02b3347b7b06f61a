"""Export of recorded runs: LeRobot."""

from app.export.episodes import ExportError
from app.export.lerobot import export_lerobot
