"""The gateway's socket."""

import pytest

from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive_gateway import DriveGateway
from stillarm.drivers.drives.drive_gateway_socket import DriveGatewaySocket

KEY = b"a key of the tests' own"


def test_a_second_gateway_on_a_port_is_refused_in_one_line() -> None:
    first = DriveGatewaySocket(DriveGateway(KEY), ("127.0.0.1", 0))
    with pytest.raises(UserError, match=r"^drive\.gateway_port: [^\n]*; [^\n]*$"):
        DriveGatewaySocket(DriveGateway(KEY), first.address)
    first.close()
    first.close()
