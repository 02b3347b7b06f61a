"""Files that people write, and what is said when they are wrong.

The bottom room: every other one may use it, and it uses none. `UserError` is the base of every
error that a person can fix, `read_config` reads a YAML file into a checked pydantic model.
"""

from config.errors import UserError, quoted, suggest
from config.reader import ConfigError, StrictModel, read_config

__all__ = ["ConfigError", "StrictModel", "UserError", "quoted", "read_config", "suggest"]
