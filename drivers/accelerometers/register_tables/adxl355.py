"""Analog Devices ADXL355: 20 bit, low noise, 2 to 8 g, a FIFO of 32 samples (96 entries of one axis).

Group delays: the data sheet's table of the digital filter's delay (2.52, 2.00, 1.78, 1.63 output periods), from memory
of the data sheet; no second source was found.
"""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    Fifo,
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
)
from stillarm.drivers.accelerometers.register_tables.words import big_20_bits

_STATUS, _FIFO_ENTRIES, _DATA, _FIFO_DATA = 0x04, 0x05, 0x08, 0x11
_FILTER, _RANGE, _POWER, _RESET = 0x28, 0x2C, 0x2D, 0x2F
_I2C_FAST = 0x80  # bit 7 of the range register, set after reset: allows speeds above 400 kHz

ADXL355 = RegisterTable(
    name="ADXL355",
    addresses=(0x1D, 0x53),
    identity_register=0x00,
    identity=b"\xad\x1d\xed",
    set_up=(
        Write(_RESET, 0x52, wait_s=0.005),
        Write(_FILTER, 0x00),
        Write(_RANGE, _I2C_FAST),
        Write(_POWER, 0x00),
    ),
    full_scales={
        2: FullScale(256_000.0, 1 << 19, {_RANGE: 0x01}),
        4: FullScale(128_000.0, 1 << 19, {_RANGE: 0x02}),
        8: FullScale(64_000.0, 1 << 19, {_RANGE: 0x03}),
    },
    filters=(
        FilterSetting(250.0, 1000.0, 1.78e-3, {_FILTER: 0x02}),
        FilterSetting(500.0, 2000.0, 1.00e-3, {_FILTER: 0x01}),
        FilterSetting(1000.0, 4000.0, 0.63e-3, {_FILTER: 0x00}),
        FilterSetting(125.0, 500.0, 3.26e-3, {_FILTER: 0x03}),
    ),
    status_register=_STATUS,
    data_register=_DATA,
    data_length=9,
    decode=big_20_bits,
    ready_mask=0x01,
    start_up_s=0.010,
    noise_m_s2_per_sqrt_hz=25e-6 * 9.80665,
    fifo=Fifo(
        start=(),  # always on
        stop=(),
        depth=32,
        count_register=_FIFO_ENTRIES,
        count_length=1,
        entries=lambda data: (data[0] & 0x7F) // 3,
        data_register=_FIFO_DATA,
        sample_length=9,
        decode=big_20_bits,
        rolling=True,
        marker=(2, 0x01),
    ),
)
