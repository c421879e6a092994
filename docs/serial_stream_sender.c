/* Frames of docs/serial-stream.md: the sender's side, without any library.
 *
 * In a 1 kHz timer: read the sensor, call stillarm_sample(), hand the frame to the port if it has room for 24 bytes,
 * drop it otherwise. Every 500th time send the frame of stillarm_description() first.
 */
#include <stdint.h>

enum { STILLARM_FRAME_BYTES = 24, STILLARM_SENSOR_FAULT = 1, STILLARM_CLIPPED = 2 };

static uint8_t *put(uint8_t *at, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++, value >>= 8)
        *at++ = (uint8_t)value;
    return at;
}

static uint16_t crc16(const uint8_t *data, int length)
{
    uint16_t crc = 0;
    for (int i = 0; i < length; i++) {
        crc ^= (uint16_t)(data[i] << 8);
        for (int bit = 0; bit < 8; bit++)
            crc = (uint16_t)(crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1);
    }
    return crc;
}

static void frame_of(uint8_t *frame, uint8_t kind, uint8_t status, uint16_t counter, uint32_t time_us,
                     const int32_t numbers[3])
{
    uint8_t *at = frame;
    *at++ = 0xA5;
    *at++ = 0x5A;
    *at++ = kind;
    *at++ = status;
    at = put(at, counter, 2);
    at = put(at, time_us, 4);
    for (int axis = 0; axis < 3; axis++)
        at = put(at, (uint32_t)numbers[axis], 4);
    const uint16_t crc = crc16(frame + 2, 20);
    *at++ = (uint8_t)(crc >> 8);
    *at = (uint8_t)crc;
}

/* A sample: acceleration along x, y, z in um/s^2; status: STILLARM_SENSOR_FAULT, STILLARM_CLIPPED or 0. */
void stillarm_sample(uint8_t frame[STILLARM_FRAME_BYTES], uint16_t counter, uint32_t time_us, uint8_t status,
                     const int32_t acceleration_um_s2[3])
{
    frame_of(frame, 1, status, counter, time_us, acceleration_um_s2);
}

/* What the sensor is: samples a second in mHz, range in um/s^2, group delay of its filter in us. */
void stillarm_description(uint8_t frame[STILLARM_FRAME_BYTES], uint16_t counter, uint32_t time_us, int32_t rate_mhz,
                          int32_t range_um_s2, int32_t delay_us)
{
    const int32_t numbers[3] = {rate_mhz, range_um_s2, delay_us};
    frame_of(frame, 2, 0, counter, time_us, numbers);
}
