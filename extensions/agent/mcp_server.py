"""An MCP server for a model that writes tasks: it works in one folder and moves no real robot."""

from __future__ import annotations

import asyncio
import json
import os
import secrets
import socket
from collections.abc import Callable
from functools import wraps
from inspect import isawaitable
from pathlib import Path
from typing import Any

from config import UserError, extra
from extensions.agent.describe import DATA
from extensions.agent.tools import TOOLS, Tools
from extensions.agent.workspace import Workspace

_INSTRUCTIONS = (
    "Write a task for a mobile manipulator: `describe` the language, `check` a draft until it has "
    "no errors, try it by `dry` and `simulate`, then `propose` it. A person starts the real robot. "
    f"{DATA}"
)


class AgentError(UserError):
    """The server lacks its extra, or cannot serve."""


def serve(folder: Path, port: int | None, say: Callable[[str], None]) -> None:
    """Serve a folder on standard input and output, or by HTTP on a port of this computer.

    Whoever connects by HTTP needs the token that `say` prints. Raises AgentError: the extra is
    missing, or the port is taken.
    """
    try:
        from mcp.server import MCPServer
        from mcp.server.mcpserver.exceptions import ToolError
        from mcp_types import CallToolResult, TextContent
    except ModuleNotFoundError:
        raise AgentError(f"the server for models needs an extra: {extra('agent')}") from None

    os.chdir(folder)  # so that a relative path is one in the folder, wherever it is read
    tools = Tools(Workspace(Path()))

    def told(tool: Callable[..., Any]) -> Callable[..., Any]:
        """The tool, whose answer goes over the wire once, and whose user errors the model reads."""

        @wraps(tool)
        async def call(*given: Any, **named: Any) -> CallToolResult:
            try:
                answer = await asyncio.to_thread(tool, *given, **named)
                answer = await answer if isawaitable(answer) else answer
                data = answer if isinstance(answer, dict) else None
                text = data.pop("text") if data else answer
            except UserError as error:
                raise ToolError(tools.hidden(str(error))) from None
            structured = json.loads(tools.hidden(json.dumps(data, ensure_ascii=False)))
            content = TextContent(type="text", text=tools.hidden(text))
            return CallToolResult(content=[content], structured_content=structured)

        return call

    server = MCPServer("frankie-task", instructions=_INSTRUCTIONS, log_level="ERROR")
    for name in TOOLS:
        server.add_tool(told(getattr(tools, name)), structured_output=False)
    if port is None:
        server.run()
        return
    import uvicorn

    try:
        listening = socket.create_server(("127.0.0.1", port))
    except OSError as error:
        raise AgentError(
            f"--port {port}: {os.strerror(error.errno or 0)}; choose another one"
        ) from None
    app, token = server.streamable_http_app(), secrets.token_urlsafe(16)
    say(f"http://127.0.0.1:{port}/mcp with the header   Authorization: Bearer {token}")

    async def guarded(scope: Any, receive: Any, send: Any) -> None:
        given = dict(scope.get("headers", ())).get(b"authorization", b"")
        if scope["type"] == "lifespan" or secrets.compare_digest(given, f"Bearer {token}".encode()):
            await app(scope, receive, send)
        else:
            await send({"type": "http.response.start", "status": 401, "headers": []})
            await send({"type": "http.response.body", "body": b""})

    uvicorn.Server(uvicorn.Config(guarded, log_level="error")).run(sockets=[listening])
