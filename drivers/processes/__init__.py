"""Drivers in processes of their own, isolated from crashes of the vendors' libraries."""
