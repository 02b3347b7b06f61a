"""The control page: `run --with page`, and `serve`, where people start tasks too.

A run tells of itself over a socket to the process that serves the page, so what browsers ask for
takes no time from the control loop.
"""
