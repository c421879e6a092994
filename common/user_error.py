"""The one exception whose text is meant for the user, and the operating system's reason in such a text."""


class UserError(Exception):
    """Something the user can mend. Its text is one line: what, where, what is allowed, what to do.

    The command line prints it on standard error and exits with status 1; nothing else catches it.
    """


def reason_of(error: OSError) -> str:
    """What the operating system says, such as "permission denied"."""
    return (error.strerror or str(error)).lower()
