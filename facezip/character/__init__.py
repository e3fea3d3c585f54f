"""What comes in: the scans of one person, their maps and tiles, and how files become them."""
