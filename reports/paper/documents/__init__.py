"""The documents of ``facezip paper`` and ``bench rig``; errors are RMSE, 0..255, of maps as packs store them."""
