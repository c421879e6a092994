"""uPlot 1.6.32 from npm (MIT, LICENSE.uplot beside it), as published: https://github.com/leeoniya/uPlot."""

__all__ = ()
