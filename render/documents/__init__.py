"""What ``facezip validate`` and ``facezip animate`` measured; ``reports`` shows it."""
