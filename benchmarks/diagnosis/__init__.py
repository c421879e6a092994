"""Blind trials: does the diagnosis find what tests/hidden_world, an independent simulation, has hidden?"""
