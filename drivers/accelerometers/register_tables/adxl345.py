"""Analog Devices ADXL345: full resolution of 3.9 mg a count, 2 to 16 g, a FIFO of 32 samples.

I2C carries at most 800 Hz at 400 kHz and 200 Hz at 100 kHz (data sheet, serial communications: faster rates lose
samples and add noise). The set-up stays at 800 Hz: a 1 kHz loop reads one sample in five twice. For a sample in every
cycle, choose another part.
"""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    Fifo,
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
    first_order_delay_s,
)
from stillarm.drivers.accelerometers.register_tables.words import little_words

_BW_RATE, _POWER, _INT_SOURCE, _FORMAT, _DATA, _FIFO_CTL, _FIFO_STATUS = (
    0x2C,
    0x2D,
    0x30,
    0x31,
    0x32,
    0x38,
    0x39,
)


def _filter(rate_hz: float, bits: int) -> FilterSetting:
    # Bandwidth: half of the rate. No group delay is stated; that of a first-order lag is assumed.
    return FilterSetting(rate_hz / 2.0, rate_hz, first_order_delay_s(rate_hz / 2.0), {_BW_RATE: bits})


ADXL345 = RegisterTable(
    name="ADXL345",
    addresses=(0x53, 0x1D),
    identity_register=0x00,
    identity=b"\xe5",
    # standby; full resolution; rate; no FIFO; measure
    set_up=(
        Write(_POWER, 0x00),
        Write(_FORMAT, 0x08),
        Write(_BW_RATE, 0x00),
        Write(_FIFO_CTL, 0x00),
        Write(_POWER, 0x08),
    ),
    full_scales={
        2: FullScale(256.0, 512, {_FORMAT: 0x00}),
        4: FullScale(256.0, 1024, {_FORMAT: 0x01}),
        8: FullScale(256.0, 2048, {_FORMAT: 0x02}),
        16: FullScale(256.0, 4096, {_FORMAT: 0x03}),
    },
    filters=(_filter(800.0, 0x0D), _filter(400.0, 0x0C), _filter(200.0, 0x0B)),
    status_register=_INT_SOURCE,
    data_register=_DATA,
    data_length=6,
    decode=little_words,
    ready_mask=0x80,
    start_up_s=1.1e-3 + 1.0 / 200.0,
    # 0.75 counts rms at 100 Hz rate, 50 Hz bandwidth
    noise_m_s2_per_sqrt_hz=0.75 / 256.0 * 9.80665 / (50.0 * 1.57) ** 0.5,
    fifo=Fifo(
        start=(Write(_FIFO_CTL, 0x80),),
        stop=(Write(_FIFO_CTL, 0x00),),
        depth=33,  # 32, plus the sample in the output registers
        count_register=_FIFO_STATUS,
        count_length=1,
        entries=lambda data: data[0] & 0x3F,
        data_register=_DATA,
        sample_length=6,
        decode=little_words,
        rolling=False,
    ),
)
