"""An MCP server for a model that writes tasks: it works in one folder and moves no real robot."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from app.agent.tools import TOOLS, Tools
from app.agent.workspace import Workspace
from config import UserError

_P = ParamSpec("_P")
_R = TypeVar("_R")
_INSTRUCTIONS = (
    "Write a task for a mobile manipulator: `describe` the language, `check` a draft until it has "
    "no errors, try it by `dry` and `simulate`, then `propose` it. A person starts the real robot."
)


class AgentError(UserError):
    """The server lacks its extra."""


def serve(folder: Path, port: int | None, say: Callable[[str], None]) -> None:
    """Serve a folder on standard input and output, or by HTTP on a port of this computer.

    Whoever connects by HTTP needs the token that `say` prints. Raises AgentError: the extra is
    missing.
    """
    try:
        from mcp.server import MCPServer
        from mcp.server.mcpserver.exceptions import ToolError
    except ModuleNotFoundError:
        hint = 'pip install "frankie-task[agent]"'
        raise AgentError(f"the server for models needs an extra: {hint}") from None

    def told(tool: Callable[_P, _R]) -> Callable[_P, _R]:
        """The tool, whose user errors are told to the model."""

        @wraps(tool)
        def call(*given: _P.args, **named: _P.kwargs) -> _R:
            try:
                return tool(*given, **named)
            except UserError as error:
                raise ToolError(str(error)) from None

        return call

    os.chdir(folder)  # so that a relative path is one in the folder, wherever it is read
    server = MCPServer("frankie-task", instructions=_INSTRUCTIONS, log_level="ERROR")
    tools = Tools(Workspace(Path()))
    for name in TOOLS:
        server.add_tool(told(getattr(tools, name)))
    if port is None:
        server.run()
        return
    import uvicorn

    app, token = server.streamable_http_app(), secrets.token_urlsafe(16)
    say(f"http://127.0.0.1:{port}/mcp with the header   Authorization: Bearer {token}")

    async def guarded(scope: Any, receive: Any, send: Any) -> None:
        given = dict(scope.get("headers", ())).get(b"authorization", b"")
        if scope["type"] == "lifespan" or secrets.compare_digest(given, f"Bearer {token}".encode()):
            await app(scope, receive, send)
        else:
            await send({"type": "http.response.start", "status": 401, "headers": []})
            await send({"type": "http.response.body", "body": b""})

    uvicorn.run(guarded, host="127.0.0.1", port=port, log_level="error")
