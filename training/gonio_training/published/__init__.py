"""The published training protocol: the table's eight architectures and ours, on rendered spheres. One command a step."""
