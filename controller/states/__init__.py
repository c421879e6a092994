"""Whether the arm may be moved and damped: the states, what leads from one to another, and the tests behind it."""
