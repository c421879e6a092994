"""An invented part: 16 bits, two ranges, one filter."""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
    first_order_delay_s,
)
from stillarm.drivers.accelerometers.register_tables.words import little_words

_ID, _CONTROL, _STATUS, _DATA = 0x00, 0x01, 0x02, 0x03

PLAIN16 = RegisterTable(
    name="PLAIN16",
    addresses=(0x20,),
    identity_register=_ID,
    identity=b"\x16",
    set_up=(Write(_CONTROL, 0x80),),  # measure; range and filter are added
    full_scales={
        2: FullScale(16384.0, 32768, {_CONTROL: 0x00}),
        4: FullScale(8192.0, 32768, {_CONTROL: 0x01}),
    },
    filters=(FilterSetting(200.0, 1000.0, first_order_delay_s(200.0), {_CONTROL: 0x00}),),
    status_register=_STATUS,
    data_register=_DATA,
    data_length=6,
    decode=little_words,
    ready_mask=0x01,
    start_up_s=0.002,
    noise_m_s2_per_sqrt_hz=0.001,
)
