"""Bytes on disk, whatever they mean: whole writes, safe names, images, OBJ, glTF containers."""
