"""Checks of every request (who, from where, how often, which file), and the bounded queue to each page.

Not here: what a page shows (live, recordings), and what a command does (operate). Begin with `guard.py`.
"""

__all__ = ["access", "guard", "page_files", "paths", "socket_handler", "subscribers"]
