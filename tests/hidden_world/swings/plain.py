"""Plain rigs: a good accelerometer, an encoder, a free camera, lateness above a floor; what no rig should be bad at."""

from dataclasses import replace

import numpy as np

from tests.hidden_world.swings.draw import Arm, draw, draw_events, log_uniform
from tests.hidden_world.swings.rig import Arrivals, Case


def draw_plain(seed: int, kind: str | None = None) -> Case:
    """A case of this seed without dead sensors, stalls, losses, a second mode, or noise that is not white."""
    wild = draw(seed, kind)
    luck = np.random.default_rng((seed, 12))
    frequency, length = log_uniform(luck, 1.5, 8.0), log_uniform(luck, 0.8, 3.5)
    w = 2.0 * np.pi * frequency
    mode = replace(wild.modes[0], frequency_hz=frequency, damping_ratio=log_uniform(luck, 0.003, 0.018))
    scale, noise = float(luck.uniform(400.0, 700.0)), log_uniform(luck, 0.03, 0.18)
    amplitude = min(log_uniform(luck, 15.0, 500.0) * noise / scale, 0.03 * length, 11.0 / (w * w))
    rate = float(luck.choice([50, 60, 65, 70, 90]))
    floor = float(luck.uniform(0.055, 0.075))
    encoder = replace(wild.joint, encoder="noisy", resolution_rad=1e-7, noise_rad=2e-5)
    accelerometer = replace(
        wild.accelerometer,
        state="good",
        gain=1.0,
        noise_m_s2=log_uniform(luck, 0.15, 0.7),
        colour=0.0,
        range_m_s2=19.6,
        age_s=0.0,
    )
    camera = replace(
        wild.camera,
        triggered=False,
        frame_rate_hz=rate,
        rate_error=0.0,
        exposure_s=float(luck.uniform(0.0075, min(0.012, 0.9 / rate))),
        scale_px_per_m=scale,
        noise_px=noise,
        colour=0.0,
        stamped=bool(luck.random() < 0.75),
    )
    arrivals = Arrivals(
        floor_s=floor,
        rest_mean_s=float(luck.uniform(0.003, 0.008)),
        rest_shape=float(luck.uniform(1.5, 4.0)),
        tail_share=0.0,
        tail_s=0.0,
        walk_s=float(luck.uniform(0.002, 0.006)),
        walk_time_s=float(luck.uniform(6.0, 15.0)),
        stall_rate_hz=0.0,
        stall_s=0.1,
        start_stall_s=0.0,
        service_s=0.001,
        lost_share=0.0,
        queue=0,
    )
    arm = Arm.seen_by(camera, frequency, length)
    events = draw_events(luck, wild.kind, arm, amplitude, wild.duration_s)
    exact = replace(wild.belief, frequency=1.0, damping=1.0, participation=1.0, scale=1.0, bandwidth=1.0)
    belief = replace(
        exact if luck.random() < 0.5 else wild.belief,
        delay_error_s=float(luck.normal(0.0, 0.0005)),
        delay_spread=1.0,
        accelerometer_noise=1.0,
        image_noise=1.0,
    )
    return replace(
        wild,
        length_m=length,
        modes=(mode,),
        joint=encoder,
        accelerometer=accelerometer,
        camera=camera,
        arrivals=arrivals,
        events=tuple(events),
        belief=belief,
        amplitude_m=amplitude,
        swinging_m=amplitude if wild.kind == "already" else 0.0,
    )
