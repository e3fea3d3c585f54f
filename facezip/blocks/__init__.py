"""Block compression: the encoders and decoders of kept libraries behind one small interface."""
