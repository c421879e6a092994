"""The sender in C that docs/serial-stream.md offers: compiled, and its bytes decoded."""

import shutil
import subprocess
from pathlib import Path

import pytest

from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder
from stillarm.drivers.accelerometers.serial_decoders.microcontroller import MICROCONTROLLER

SENDER = Path(__file__).parents[4] / "docs" / "serial_stream_sender.c"
MAIN = """
#include "%s"
#include <stdio.h>

int main(void)
{
    uint8_t frame[STILLARM_FRAME_BYTES];
    stillarm_description(frame, 7, 1000, 1000000, 39200000, 450);
    fwrite(frame, 1, sizeof frame, stdout);
    for (int i = 0; i < 300; i++) {
        const int32_t xyz[3] = {i * 1000, -i, -2147483647 + i};
        stillarm_sample(frame, (uint16_t)(65400 + i), 4294967000u + (uint32_t)i, i == 5, xyz);
        fwrite(frame, 1, sizeof frame, stdout);
    }
    return 0;
}
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_what_it_sends_is_what_is_read(tmp_path: Path) -> None:
    source, program = tmp_path / "main.c", tmp_path / "sender"
    source.write_text(MAIN % SENDER)
    subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-o", program, source], check=True)
    sent = subprocess.run([program], check=True, capture_output=True).stdout
    decoder = FrameDecoder(MICROCONTROLLER)
    samples = decoder.feed(sent)
    assert (decoder.frames, decoder.rejected) == (301, 0)
    told = decoder.description
    assert told is not None
    assert (told.rate_hz, told.range_m_s2) == (1000.0, pytest.approx(39.2))
    assert told.delay_s == pytest.approx(450e-6)
    assert len(samples) == 299  # one with the sensor's fault
    assert [sample.counter for sample in samples] == [(65400 + i) % 65536 for i in range(300) if i != 5]
    last = samples[-1]
    assert (last.x_m_s2, last.y_m_s2) == (pytest.approx(0.299), pytest.approx(-299e-6))
    assert last.z_m_s2 == pytest.approx(-2147.483348)
    assert last.time_s == pytest.approx((4294967000 + 299) % 2**32 * 1e-6)
