"""What runs beside a daemon and tells of it: the recorder process, live telemetry, log lines.

Not here: the file format (common/recording). Begin with recorder_client.py, the daemon's side.
"""

__all__ = ["recorder_client", "structured_log", "telemetry"]
