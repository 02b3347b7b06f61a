"""Tools for authors of tasks: findings, dry runs, node reference, teaching of poses."""

from app.authoring.dry import again_on_save, dry_run
from app.authoring.findings import explained, findings, patched
from app.authoring.node_reference import show_all, show_one
from app.authoring.teach import teach
