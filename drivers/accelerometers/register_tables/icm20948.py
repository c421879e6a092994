"""TDK InvenSense ICM-20948: 16 bit, 2 to 16 g, a FIFO of 512 bytes, registers in banks.

Data ready: bit 0 of INT_STATUS_1, 0x1A, the same in Zephyr's and Silicon Labs' drivers. The data sheet states
bandwidths but no delays. They are the MPU-9250's bandwidths (420, 218.1, 99, 44.8 Hz, delayed by 1.38, 1.88, 2.88,
4.88 ms) at a clock 1.125 times faster. The delays here are therefore inferred: those of the MPU-9250 divided by 1.125.
"""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    Fifo,
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
)
from stillarm.drivers.accelerometers.register_tables.words import big_words

_BANK = 0x7F
_USER_CTRL, _POWER, _INT_ENABLE_1, _INT_STATUS_1, _DATA = 0x03, 0x06, 0x11, 0x1A, 0x2D  # bank 0
_FIFO_EN_2, _FIFO_RST, _FIFO_COUNT, _FIFO = 0x67, 0x68, 0x70, 0x72  # bank 0
_DIVIDER_1, _DIVIDER_2, _ACCEL_CONFIG = 0x10, 0x11, 0x14  # bank 2
_FASTER = 1.125


def _filter(setting: int, bandwidth_hz: float, delay_of_9250_s: float) -> FilterSetting:
    return FilterSetting(bandwidth_hz, 1125.0, delay_of_9250_s / _FASTER, {_ACCEL_CONFIG: setting << 3 | 1})


ICM20948 = RegisterTable(
    name="ICM-20948",
    addresses=(0x68, 0x69),
    identity_register=0x00,
    identity=b"\xea",
    before_identity=(Write(_BANK, 0x00),),
    set_up=(
        Write(_BANK, 0x00),
        Write(_POWER, 0x01),
        Write(_USER_CTRL, 0x00),
        Write(_FIFO_EN_2, 0x00),
        Write(_INT_ENABLE_1, 0x01),
        Write(_BANK, 0x20),
        Write(_DIVIDER_1, 0x00),
        Write(_DIVIDER_2, 0x00),
        Write(_ACCEL_CONFIG, 0x00),
        Write(_BANK, 0x00),
    ),
    full_scales={
        2: FullScale(16384.0, 32768, {_ACCEL_CONFIG: 0x00}),
        4: FullScale(8192.0, 32768, {_ACCEL_CONFIG: 0x02}),
        8: FullScale(4096.0, 32768, {_ACCEL_CONFIG: 0x04}),
        16: FullScale(2048.0, 32768, {_ACCEL_CONFIG: 0x06}),
    },
    filters=(
        _filter(7, 473.0, 1.38e-3),
        _filter(1, 246.0, 1.88e-3),
        _filter(2, 111.4, 2.88e-3),
        _filter(3, 50.4, 4.88e-3),
    ),
    status_register=_INT_STATUS_1,
    data_register=_DATA,
    data_length=6,
    decode=big_words,
    ready_mask=0x01,
    start_up_s=0.030,
    noise_m_s2_per_sqrt_hz=230e-6 * 9.80665,
    fifo=Fifo(
        start=(
            Write(_FIFO_EN_2, 0x10),
            Write(_FIFO_RST, 0x1F),
            Write(_FIFO_RST, 0x00),
            Write(_USER_CTRL, 0x40),
        ),
        stop=(Write(_USER_CTRL, 0x00), Write(_FIFO_EN_2, 0x00)),
        depth=85,  # 512 bytes
        count_register=_FIFO_COUNT,
        count_length=2,
        entries=lambda data: (int.from_bytes(data, "big") & 0x1FFF) // 6,
        data_register=_FIFO,
        sample_length=6,
        decode=big_words,
        rolling=True,
    ),
)
