"""Commands that make, convert, mend, replay and diagnose recordings, calibrate from them, and list the causes."""
