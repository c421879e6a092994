"""The preflight behind `stillarm check`: finds what is wrong with machine and rig, without moving anything.

Begin with `walk.py`. Each other module gathers the facts of one part and judges them.
"""
