"""Tools for authors of tasks: dry runs, node reference, teaching of poses."""

from app.authoring.dry import DryRun, dry_run
from app.authoring.node_reference import UnknownWordError, show_all, show_one
from app.authoring.script import ScriptError
from app.authoring.teach import Form, TeachError, teach

__all__ = [
    "DryRun",
    "Form",
    "ScriptError",
    "TeachError",
    "UnknownWordError",
    "dry_run",
    "show_all",
    "show_one",
    "teach",
]
