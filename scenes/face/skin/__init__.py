"""Skin evaluated at the texel: albedo, and what expressions do to it."""
