"""A language model writes tasks, and tries them in simulation: `mcp` and `ask`."""
