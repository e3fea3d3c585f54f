"""``facezip rates``: error against bytes of GPU memory, packs beside block compression of every texture."""
