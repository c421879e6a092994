"""What travels by UDP: the kinds of messages, their fields, packing and checking them, and whose are taken.
docs/protocol.md

Not here: sockets, keys and clocks (common/link). Begin with datagram.py.
"""

__all__ = ["datagram", "fields", "messages", "visual_sample"]
