"""The web viewer, served from this process: its files, and a server that keeps it at home.

The viewer's own program would serve them too, but resolves the name of a telemetry host, keeps a
third of a core busy, and lets the page in the browser ask for fonts and releases elsewhere.
"""

from app.live.web.bounded_server import PATIENCE, BoundedServer
from app.live.web.file_server import FileServer
from app.live.web.replies import Replies
from app.live.web.viewer_files import (
    FILES,
    WebFilesError,
    viewer_address,
    viewer_environment,
    viewer_page,
    viewer_policy,
    viewer_program,
    viewer_web_files,
)

__all__ = [
    "FILES",
    "PATIENCE",
    "BoundedServer",
    "FileServer",
    "Replies",
    "WebFilesError",
    "viewer_address",
    "viewer_environment",
    "viewer_page",
    "viewer_policy",
    "viewer_program",
    "viewer_web_files",
]
