"""``facezip.json``, which every export has, and what ``facezip export`` says of it."""
