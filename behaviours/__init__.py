"""What a robot can do: one behaviour a file, each a leaf of a task tree."""
