"""The emulated chips by bytes, as their data sheets describe them: power-up, reset, banks, what frees data-ready."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.drivers.buses.parts import SENSED_PARTS, open_part
from stillarm.drivers.emulated_chips.shared_registers import SensedRegisters
from tests.fixtures.register_chips import NAME

PARTS = sorted(set(SENSED_PARTS) - {"lis3lv02dq"})


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=20), st.integers(0, 200)), max_size=12))
def test_no_bytes_make_a_chip_raise(part: str, transfers: list[tuple[bytes, int]]) -> None:
    registers = SensedRegisters(NAME, SENSED_PARTS[part])
    adapter = open_part(NAME, 0.0)
    device = adapter._device
    try:
        for data, length in transfers:
            device.write(data)
            registers.publish((30.0, -30.0, 0.1))
            assert len(device.read(length)) == length
    finally:
        adapter.close()
        registers.close()
