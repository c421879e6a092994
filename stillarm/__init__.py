"""The command line: `main.py` finds the subcommand, `commands/` has one file for each, `preflight/` is `check`.

Logic does not belong here; a command calls the package that does the work.
"""
