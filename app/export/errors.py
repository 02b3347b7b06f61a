"""What keeps runs from being exported."""

from config import UserError


class ExportError(UserError):
    """Runs cannot be exported; the text says which and why."""
