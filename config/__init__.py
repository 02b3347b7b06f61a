"""Strict YAML, user errors with hints, and plug-ins.

`UserError` is the base of every error that a user can fix. `config.reader` reads a strict YAML file
into a pydantic model and `config.planar` has plane geometry: apart, as every command imports this.
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
from config.plugins import (
    DoorError,
    PluginError,
    entries,
    entry_of,
    find,
    imported,
    package_of,
    used,
)
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
from config.user_cache import user_cache
from config.yaml_rules import LAYOUT, MISSING_KEY, UNKNOWN_KEY, VALUE, YAML_RULES, Rule
