"""Drivers in processes of their own, isolated from crashes of the vendors' libraries.

`process` is such a process as seen by its parent, `child` the parent as seen by the process;
`mailbox` shares the newest record between them, `light` starts a process without importing the
project, `claims` lets only one process of the computer command a machine.
"""
