"""ST LIS3LV02DQ, the paper's accelerometer: 12 bit, 2 or 6 g, no FIFO."""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
    first_order_delay_s,
)
from stillarm.drivers.accelerometers.register_tables.words import little_words

_CTRL1, _CTRL2 = 0x20, 0x21


def _filter(rate_hz: float, bits: int) -> FilterSetting:
    # Bandwidth: a quarter of the rate. No group delay is stated; that of a first-order lag is assumed.
    bandwidth_hz = rate_hz / 4.0
    return FilterSetting(bandwidth_hz, rate_hz, first_order_delay_s(bandwidth_hz), {_CTRL1: bits})


LIS3LV02DQ = RegisterTable(
    name="LIS3LV02DQ",
    addresses=(0x1D,),
    identity_register=0x0F,
    identity=b"\x3a",
    # CTRL2: block data update, data-ready; CTRL1: power on, all axes
    set_up=(Write(_CTRL2, 0x44), Write(_CTRL1, 0xC7)),
    full_scales={2: FullScale(1024.0, 2048, {}), 6: FullScale(340.0, 2048, {_CTRL2: 0x80})},
    filters=(_filter(2560.0, 0x30), _filter(640.0, 0x20), _filter(160.0, 0x10)),
    auto_increment=0x80,
    status_register=0x27,
    data_register=0x28,
    data_length=6,
    decode=little_words,
    ready_mask=0x08,
    start_up_s=5.0 / 2560.0,
    noise_m_s2_per_sqrt_hz=9.8e-3,  # about a count in 100 Hz; the data sheet states none
)
