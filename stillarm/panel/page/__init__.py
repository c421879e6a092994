"""The files that the browser loads: one sheet, ES modules, no build step. Data only; `vendor/` holds uPlot with its
licence."""

__all__ = ()
