"""The subcommands, a file each: its arguments, and the run that prints. stillarm/main.py finds them by name.

Not here: what a command does, which is in the package that its imports name.
"""
