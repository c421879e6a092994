"""Examples of the three kinds of files, installed with the program: configuration, model, scenario."""
