"""Application: command line, sessions, live view, review and export of runs."""
