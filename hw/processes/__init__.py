"""Drivers in processes of their own, which libraries of vendors can crash, abort and hang.

`process` is such a process as its parent sees it, `child` the parent as the process sees it,
`mailbox` the newest record of one for the other, and `light` starts a process without the project.
`claims` lets one process of the computer command a machine.
"""
