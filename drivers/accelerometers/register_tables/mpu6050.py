"""TDK InvenSense MPU-6050: 16 bit, 2 to 16 g, a FIFO of 1024 bytes. Also on boards named GY-521.

Bandwidths and delays: the register map's table of DLPF_CFG, the same in three public drivers. For its first setting it
states 260 Hz and 0 ms, which is impossible for a filter of 260 Hz; the delay of a first-order lag is used. The rate
divider then counts 8 kHz.
"""

from stillarm.drivers.accelerometers.register_tables.register_table import (
    Fifo,
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
    first_order_delay_s,
)
from stillarm.drivers.accelerometers.register_tables.words import big_words

_DIVIDER, _CONFIG, _ACCEL_CONFIG, _FIFO_EN, _INT_ENABLE = 0x19, 0x1A, 0x1C, 0x23, 0x38
_INT_STATUS, _DATA, _USER_CTRL, _POWER, _FIFO_COUNT, _FIFO = 0x3A, 0x3B, 0x6A, 0x6B, 0x72, 0x74


def _filter(setting: int, bandwidth_hz: float, delay_s: float) -> FilterSetting:
    divider = 7 if setting == 0 else 0
    return FilterSetting(bandwidth_hz, 1000.0, delay_s, {_CONFIG: setting, _DIVIDER: divider})


MPU6050 = RegisterTable(
    name="MPU-6050",
    addresses=(0x68, 0x69),
    identity_register=0x75,
    identity=b"\x68",
    # awake on a gyroscope's clock; no FIFO; filter; divider; range; data ready shown in the status
    set_up=(
        Write(_POWER, 0x01),
        Write(_FIFO_EN, 0x00),
        Write(_USER_CTRL, 0x00),
        Write(_CONFIG, 0x00),
        Write(_DIVIDER, 0x00),
        Write(_ACCEL_CONFIG, 0x00),
        Write(_INT_ENABLE, 0x01),
    ),
    full_scales={
        2: FullScale(16384.0, 32768, {_ACCEL_CONFIG: 0x00}),
        4: FullScale(8192.0, 32768, {_ACCEL_CONFIG: 0x08}),
        8: FullScale(4096.0, 32768, {_ACCEL_CONFIG: 0x10}),
        16: FullScale(2048.0, 32768, {_ACCEL_CONFIG: 0x18}),
    },
    filters=(
        _filter(1, 184.0, 2.0e-3),
        _filter(0, 260.0, first_order_delay_s(260.0)),
        _filter(2, 94.0, 3.0e-3),
        _filter(3, 44.0, 4.9e-3),
    ),
    status_register=_INT_STATUS,
    data_register=_DATA,
    data_length=6,
    decode=big_words,
    ready_mask=0x01,
    start_up_s=0.030,
    noise_m_s2_per_sqrt_hz=400e-6 * 9.80665,
    fifo=Fifo(
        start=(Write(_FIFO_EN, 0x08), Write(_USER_CTRL, 0x04), Write(_USER_CTRL, 0x40)),
        stop=(Write(_USER_CTRL, 0x00), Write(_FIFO_EN, 0x00)),
        depth=170,  # 1024 bytes
        count_register=_FIFO_COUNT,
        count_length=2,
        entries=lambda data: int.from_bytes(data, "big") // 6,
        data_register=_FIFO,
        sample_length=6,
        decode=big_words,
        rolling=True,
    ),
)
