"""Not real-time: captures frames, tracks features, sends the displacement of the image with its timestamp."""
