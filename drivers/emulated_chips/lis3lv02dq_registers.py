"""The registers of an emulated LIS3LV02DQ, and its sensing side.

Not emulated: self-test, high-pass filter, interrupts, offset and gain trimming (their registers only store).
"""

from stillarm.drivers.emulated_chips.shared_registers import SensedPart, Sensing

WHO_AM_I, CTRL1, CTRL2, CTRL3, STATUS, OUT_X_L = 0x0F, 0x20, 0x21, 0x22, 0x27, 0x28
IDENTITY = 0x3A
POWER_UP_MASK, RATE_MASK, AXES_MASK = 0xC0, 0x30, 0x07
SIX_G, BLOCK_UPDATE, BIG_ENDIAN, LEFT_JUSTIFIED = 0x80, 0x40, 0x20, 0x01
_RATES_HZ = (40.0, 160.0, 640.0, 2560.0)
_COUNTS_PER_G = {False: 1024.0, True: 340.0}
_LOWEST, _HIGHEST = -2048, 2047  # 12 bit
_SENSING = {
    (rate, six_g): Sensing(rate_hz, counts_per_g, _LOWEST, _HIGHEST)
    for rate, rate_hz in enumerate(_RATES_HZ)
    for six_g, counts_per_g in _COUNTS_PER_G.items()
}


def _sensing(registers: memoryview) -> Sensing | None:
    control = registers[CTRL1]
    if not control & POWER_UP_MASK:
        return None
    return _SENSING[(control & RATE_MASK) >> 4, registers[CTRL2] & SIX_G != 0]


LIS3LV02DQ_PART = SensedPart(
    name="lis3lv02dq",
    number=1,
    power_up={WHO_AM_I: IDENTITY, CTRL1: AXES_MASK, CTRL3: 0x08},
    sensing=_sensing,
)
