"""`fused`: accelerometer, image, frame counter, stamps, arrivals and joint motion in one estimator, one part a file."""
