"""What helps to write a task: runs without a robot, the reference of words."""

from app.authoring.dry import DryRun, ScriptError, dry_run
from app.authoring.node_reference import UnknownWordError, show_all, show_one

__all__ = ["DryRun", "ScriptError", "UnknownWordError", "dry_run", "show_all", "show_one"]
