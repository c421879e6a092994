"""How the vector is fitted, and what a fit is worth: baseline, forms of causes, free terms, laws of noise.

Not here: which cause is taken, and what is said (decision). Begin with fit.py, then evidence.py. causes/ holds how
those causes are looked for that need more than their declaration says.
"""

__all__ = [
    "band_score",
    "baseline",
    "begun",
    "candidates",
    "cause",
    "causes",
    "clocks",
    "comparison",
    "early_baseline",
    "evidence",
    "fit",
    "fitted",
    "forms",
    "freeform",
    "frequency_course",
    "image_dating",
    "image_walk",
    "impact_onsets",
    "impacts",
    "laws",
    "pulls",
    "screen",
]
