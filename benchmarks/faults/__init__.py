"""Fault injection, in virtual time and into the real processes, with one judge for both."""
