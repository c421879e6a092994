"""An operator's commands from the page: what is allowed now and why not, and the signed datagrams.

`actions.py` and `permitted.py` are pure; `desk.py` does what they permit, and `sender.py` has the socket.
"""

__all__ = ["actions", "desk", "permitted"]
