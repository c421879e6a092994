"""ST LIS3DH: 12 bit in high resolution, 10 bit in normal mode, 2 to 16 g, a FIFO of 32 samples.

Status bits 0-2, 3 (all axes ready) and 7 (overrun) of 0x27: the same in ST's own and in two other public drivers.
Scale: ST's driver uses 1 mg a count of the 12-bit value (12 mg at 16 g), hence 16000 counts a g left-justified. Some
other drivers use 16380, which is 2.4 % more.
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

_CTRL1, _CTRL4, _CTRL5, _FIFO_CTRL, _FIFO_SRC = 0x20, 0x23, 0x24, 0x2E, 0x2F
_HIGH_RESOLUTION = 0x08
_RATE_1344_HZ, _RATE_400_HZ = 0x90, 0x70


def _filter(rate_hz: float, rate_bits: int, *, high_resolution: bool) -> FilterSetting:
    # Bandwidth: a ninth of the rate in high resolution, half of it in normal mode; first-order lag assumed.
    bandwidth_hz = rate_hz / (9.0 if high_resolution else 2.0)
    step = 16 if high_resolution else 64  # 12 bits or 10 of 16
    bits = {_CTRL1: rate_bits, _CTRL4: _HIGH_RESOLUTION if high_resolution else 0}
    return FilterSetting(round(bandwidth_hz), rate_hz, first_order_delay_s(bandwidth_hz), bits, step)


LIS3DH = RegisterTable(
    name="LIS3DH",
    addresses=(0x18, 0x19),
    identity_register=0x0F,
    identity=b"\x33",
    # CTRL5, FIFO_CTRL: no FIFO; CTRL4: block data update; CTRL1: all axes
    set_up=(Write(_CTRL5, 0x00), Write(_FIFO_CTRL, 0x00), Write(_CTRL4, 0x80), Write(_CTRL1, 0x07)),
    full_scales={
        2: FullScale(16000.0, 32768, {_CTRL4: 0x00}),
        4: FullScale(8000.0, 32768, {_CTRL4: 0x10}),
        8: FullScale(4000.0, 32768, {_CTRL4: 0x20}),
        16: FullScale(16000.0 / 12.0, 32768, {_CTRL4: 0x30}),
    },
    filters=(
        _filter(1344.0, _RATE_1344_HZ, high_resolution=True),
        _filter(1344.0, _RATE_1344_HZ, high_resolution=False),
        _filter(400.0, _RATE_400_HZ, high_resolution=True),
    ),
    auto_increment=0x80,
    status_register=0x27,
    data_register=0x28,
    data_length=6,
    decode=little_words,
    ready_mask=0x08,
    start_up_s=0.007,  # 7 samples at the slowest supported rate
    noise_m_s2_per_sqrt_hz=220e-6 * 9.80665,
    fifo=Fifo(
        start=(Write(_CTRL5, 0x40), Write(_FIFO_CTRL, 0x80)),
        stop=(Write(_FIFO_CTRL, 0x00), Write(_CTRL5, 0x00)),
        depth=32,
        count_register=_FIFO_SRC,
        count_length=1,
        # overrun (bit 6): full, 32 samples; empty (bit 5)
        entries=lambda data: 32 if data[0] & 0x40 else 0 if data[0] & 0x20 else data[0] & 0x1F,
        data_register=0x28,
        sample_length=6,
        decode=little_words,
        rolling=True,
    ),
)
