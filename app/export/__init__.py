"""Export of recorded runs: LeRobot, and MCAP."""

from app.export.episodes import ExportError
from app.export.lerobot import export_lerobot
from app.export.mcap import export_mcap
