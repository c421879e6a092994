"""An operator's commands from the page: what is allowed now and why not, and the signed datagrams.

`actions.py`, `permitted.py` and `answered.py` are pure; `desk.py` does what is permitted, `sender.py` has the socket.
"""

__all__ = ["actions", "answered", "desk", "permitted"]
