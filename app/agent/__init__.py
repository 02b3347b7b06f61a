"""`frankie-task mcp` and `ask`: a language model writes tasks, and tries them in simulation."""

from app.agent.ask import ask, name_for
from app.agent.endpoint import Endpoint
from app.agent.server import serve
from app.agent.tools import Tools
from app.agent.workspace import Workspace
