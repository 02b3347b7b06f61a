"""Web access: free ports, the files of the web viewer, and HTTP servers on loopback."""

from app.live.web.http_server import BoundedServer, FileServer, Replies
from app.live.web.viewer_files import (
    ANCESTORS,
    WebFilesError,
    viewer_address,
    viewer_environment,
    viewer_program,
    viewer_web_files,
)
