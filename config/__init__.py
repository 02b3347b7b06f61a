"""Files that people write, and what is said when they are wrong.

Every other room may use it and it uses none: the strict YAML reader, checked models, and the one
base class of errors that a person can fix.
"""
