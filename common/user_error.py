"""The one exception whose text is meant for the user."""


class UserError(Exception):
    """Something the user can mend. Its text is one line: what, where, what is allowed, what to do.

    The command line prints it on standard error and exits with status 1; nothing else catches it.
    """
