"""One file for each command: its arguments, and the call that runs it."""
