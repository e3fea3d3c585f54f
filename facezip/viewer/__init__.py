"""The head on a screen: a scene out of a pack, the page that shows it, and a server for this machine alone.

The page is TypeScript in ``web/``; ``python -m facezip.viewer.build`` bundles it, three.js included, into ``bundle/``,
and the head alone as a module for other pages with three.js.
"""
