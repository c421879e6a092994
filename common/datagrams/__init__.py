"""What travels by UDP: the kinds of messages, their fields, and packing and checking them. docs/protocol.md

Not here: sockets, sessions and clocks (common/link). Begin with datagram.py.
"""

__all__ = ["datagram", "fields", "messages", "visual_datagram", "visual_sample"]
