"""Image errors of several sets of maps under the same looks, on the same light paths."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.machine.progress import task
from render.importance import Sight
from render.metrics import display, image_rmse
from render.presence import check_present, face_triangles
from render.skins import SkinMaps, upload
from render.staging import staged_original

Skins = Callable[[str], SkinMaps]


def image_errors(character: Character, candidates: Sequence[Skins], sight: Sight) -> NDArray[np.float64]:
    """Image RMSE of K candidates against the character: ``(K, expressions, looks)``, 0..255, over head pixels.

    Parameters
    ----------
    character : the original, with all the maps that renderers know.
    candidates : each gives what is rendered (:func:`render.staging.staged`) for an expression's name.
    sight : the looks, and how they are rendered.

    Raises
    ------
    FaceZipError
        ``NOTHING_TO_SEE``: a picture shows no face.
    """
    shape = len(candidates), len(character.expressions), len(sight.looks)
    errors, face = np.zeros(shape), face_triangles(character)
    renderer, original = sight.renderer(character), staged_original(character)
    with task("Rendering", shape[1] * shape[2]) as advance:
        for n, name in enumerate(character.expressions):
            renderer.pose(character.mesh_vertices(name))
            skins = [upload(skin(name)) for skin in (original, *candidates)]
            for i, (view, rig) in enumerate(sight.looks):
                images = renderer.render(skins, view, rig, sight.spp, sight.seed)
                check_present(images.linear[0], renderer.triangles(view), face, f"{name}, {view.name} view")
                shown, *others = display(images.linear[:, images.coverage >= 0.5])
                errors[:, n, i] = [image_rmse(shown, other) for other in others]
                advance()
    return errors
