"""The joint with its input and sensors as one simulation of named numbers, and the same blocks side by side, quickly.

Not here: how the numbers are fitted (fitting). Begin with greybox.py.
"""

__all__ = ["greybox", "input_path", "laws", "play_side_by_side", "sensing", "side_by_side"]
