"""Bytes on disk, whatever they mean: whole writes, safe names, images, OBJ, GLB containers."""
