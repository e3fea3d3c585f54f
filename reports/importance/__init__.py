"""What the importance of texels looks like, and what a fit gains from it."""
