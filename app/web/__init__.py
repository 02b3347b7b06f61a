"""Web access: free ports, the files of the Rerun web viewer, and a server of these files."""

from app.web.file_server import RECORDING, FileServer
from app.web.ports import LOOPBACK, Address, choose_port, listening, reachable
from app.web.viewer_files import (
    ANCESTORS,
    WebFilesError,
    read_file,
    viewer_address,
    viewer_environment,
    viewer_policy,
    viewer_program,
    viewer_web_files,
)
