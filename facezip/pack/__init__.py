"""What comes out: compressed textures in memory (equations 1 and 8), as 8 bits, and as verified files."""
