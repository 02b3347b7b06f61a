"""`frankie-task serve`: one page from which people start tasks, watch them, and look at runs."""

from app.serve.desk import TaskDesk
