"""`frankie-task mcp`: a language model writes tasks, and tries them in simulation."""

from app.agent.server import serve
