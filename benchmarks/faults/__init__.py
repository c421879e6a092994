"""The faults that a rig has to stand, injected in virtual time and into the real processes; and the judge of both."""
