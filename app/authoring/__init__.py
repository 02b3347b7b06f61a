"""Tools for authors of tasks: findings, dry runs, node reference, teaching of poses."""

from app.authoring.dry import again_on_save, dry_run
from app.authoring.findings import explained, findings, patched
from app.authoring.node_reference import all_words, one_word
from app.authoring.teach import teach
