"""Commissioning: small moves of the joint, watched, and the model that they identify."""
