"""Strict YAML configuration files, user errors with hints, plug-ins and lazy imports.

`UserError` is the base of every error that a user can fix; `read_config` reads a strict YAML file
into a pydantic model; `read_yaml`, `validate` and `Diagnostics` are its parts, for other files.
"""

from config.diagnostics import (
    Diagnostic,
    Diagnostics,
    Hint,
    Location,
    Severity,
    TooManyErrorsError,
    UserError,
    counted,
    extra,
    nearest,
    parted,
    quoted,
    suggest,
)
from config.lazy import lazy_face
from config.plugins import PluginError, entries, imported
from config.reader import ConfigError, StrictModel, read_config, validate
from config.rules import LAYOUT, MISSING_KEY, UNKNOWN_KEY, VALUE, YAML_RULES, Rule
from config.strict_yaml import (
    Plain,
    YamlEntry,
    YamlList,
    YamlMap,
    YamlScalar,
    YamlValue,
    content,
    describe,
    parse_scalar,
    parse_yaml,
    read_yaml,
    texts,
    written,
)
