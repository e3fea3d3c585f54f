"""The embedded character's head: a procedural sculpt, its chart, and the 52 ARKit shapes."""
