"""From fits to a verdict: causes taken one after another within a budget of time, and what that proves.

Not here: how a fit is made or scored (fitting), how forms are compared (search), and how the verdict is told (report).
Begin with run.py.
"""

__all__ = ["budget", "decide", "explain", "rival_causes", "run"]
