"""What every layer, mask and activation of a pack does: the page of ``facezip layers``."""
