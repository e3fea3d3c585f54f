"""Scans with more than one albedo: normal, roughness and other maps, on one or several UDIM tiles.

Every map on every tile is a :class:`facezip.character.Character` of its own, with the same meshes, seen where its tile
lies in UV: so whatever compresses, rasterises or measures a character does so here. What is shared is the sum: maps of
a tile share weight maps, tiles share masks and principal components.
"""
