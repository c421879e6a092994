"""The CSV bundle: fast.csv, frames.csv, model.toml in and out of a recording. docs/recording.md describes it."""

__all__ = ["bundle_export", "bundle_import", "mapped_data"]
