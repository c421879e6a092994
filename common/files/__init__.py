"""The three kinds of TOML files (configuration, model, scenario) as typed structures, checked on the way in.

Here too: what follows from the model file alone (beam, effects). Not here: recordings and CSV. Begin with
configuration.py.
"""

__all__ = [
    "beam",
    "configuration",
    "driven_joint",
    "effects",
    "effects_check",
    "model",
    "output_folder",
    "scenario",
    "typed_toml",
]
