"""What both computers share: the three kinds of files, the link, shared memory, recordings, processes. Knows no device.

Not here: anything that only the controller, the supervisor or the simulation needs. Begin with
files/configuration.py, then
datagrams/datagram.py and recording/topics.py.
"""
