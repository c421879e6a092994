"""The CSV bundle: fast.csv, frames.csv, model.toml in and out of a recording. docs/recording.md
describes it.
"""
