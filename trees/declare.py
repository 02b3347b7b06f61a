"""Write what is made from the classes of the leaves: `python -m trees.declare`."""

from behaviours import LEAVES
from trees.language import DECLARATIONS, declarations_text, describe_leaves
from trees.schema import SCHEMA_FILE, schema_text

if __name__ == "__main__":
    leaves = describe_leaves(LEAVES)
    DECLARATIONS.write_text(declarations_text(leaves), encoding="utf-8")
    SCHEMA_FILE.write_text(schema_text(leaves), encoding="utf-8")
