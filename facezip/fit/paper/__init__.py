"""The paper's own method: masks, fragments, and the stitching of fragments into difference textures."""
