"""The Rerun web viewer, served from this process.

The viewer's own server would resolve the name of a telemetry host, keep a third of a core busy, and
let the page ask other hosts for fonts and releases.
"""

from app.live.web.http_server import PATIENCE, BoundedServer, FileServer, Replies
from app.live.web.viewer_files import (
    WebFilesError,
    viewer_address,
    viewer_environment,
    viewer_program,
    viewer_web_files,
)

__all__ = [
    "PATIENCE",
    "BoundedServer",
    "FileServer",
    "Replies",
    "WebFilesError",
    "viewer_address",
    "viewer_environment",
    "viewer_program",
    "viewer_web_files",
]
