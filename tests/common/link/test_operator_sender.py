"""An operator's datagrams count after the controller was heard."""

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.controller.input.exchange import ReferenceExchange
from stillarm.controller.safety.table import Operator
from tests.fixtures.link_ends import SENDER, SESSION


def test_a_datagram_counts_after_the_sender_has_heard_from_this_controller() -> None:
    """The first one is greeted, the next one taken; a replayed one is not, nor one for another session."""
    exchange, sender = ReferenceExchange(DEMO_KEY, SESSION), OperatorSender(DEMO_KEY, SENDER)
    exchange.take([sender.command(Operator.ARM)], 0.0)
    assert exchange.asked() == 0
    hello = exchange.hello()
    assert hello is not None
    sender.take([hello])
    assert sender.known
    word = sender.command(Operator.DISARM)
    exchange.take([word, sender.command(Operator.CLEAR)], 0.0)
    assert exchange.asked() == Operator.DISARM | Operator.CLEAR
    assert exchange.asked() == 0
    exchange.take([word], 0.0)
    assert exchange.asked() == 0
    other = ReferenceExchange(DEMO_KEY, SESSION + 2)
    other.take([sender.command(Operator.ARM)], 0.0)
    assert other.asked() == 0
