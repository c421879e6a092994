"""An operator's stop between two parts of a commissioning, by the command's own datagrams."""

import threading
import time
from contextlib import closing

import pytest

from stillarm.commands.rig.operate_command import operate
from stillarm.common.files.configuration import Configuration, Link
from stillarm.common.link.free_ports import free_ports
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning.stop_listener import StopListener


def configuration() -> Configuration:
    """With a port of its own."""
    return Configuration(link=Link(reference_port=free_ports(1)[0]))


def test_a_stop_is_answered_ends_the_rest_and_stays() -> None:
    here = configuration()
    with closing(StopListener(here.link)) as listener:
        began = time.monotonic()
        asking = threading.Thread(target=operate, args=(here, "stop"))
        asking.start()
        listener.rest(30.0)
        asking.join()
        assert time.monotonic() - began < 20.0 and listener.stopped
        listener.close()
        assert listener.stopped


def test_nothing_else_is_a_stop() -> None:
    """Another operator's word is answered; the next controller is to hear it again."""
    here = configuration()
    with closing(StopListener(here.link)) as listener:
        operate(here, "disarm")
        listener.rest(0.05)
        assert not listener.stopped


def test_the_port_is_left_to_the_next_controller() -> None:
    """While one listens, none other can; after it has been closed, twice, one can."""
    here = configuration()
    listener = StopListener(here.link)
    with pytest.raises(UserError, match=r"link\.reference_port: cannot listen"):
        StopListener(here.link)
    listener.close()
    listener.close()
    StopListener(here.link).close()


@pytest.mark.slow
def test_a_stop_waits_for_a_controller_that_starts() -> None:
    """A second and more, where another word gives up."""
    here, listeners = configuration(), []
    late = threading.Timer(2.0, lambda: listeners.append(StopListener(here.link)))
    late.start()
    with pytest.raises(UserError, match="no controller answers"):
        operate(here, "disarm")
    operate(here, "stop")
    late.join()
    with closing(listeners[0]) as listener:
        listener.rest(1.0)
        assert listener.stopped
