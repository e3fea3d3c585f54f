"""Models of every shape that shaders have a way for, and a GPU to draw with."""

import pytest

from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import KINDS, grey, layered_model
from tests.facezip.export.gpu import Gpu, software

MODELS = {
    "four slots": random_model(meshes=True),
    "one slot": random_model(slots=1, meshes=True),
    "two layers": random_model(slots=5, expressions=7, meshes=True),
    "uniform weights": random_model(weights=(1, 1), meshes=True),
    "grey": grey(random_model(meshes=True)),
    "five maps": layered_model(),
    "normals alone, two layers": layered_model(kinds=(KINDS[0], KINDS[2]), slots=5),
    "three maps, uniform weights": layered_model(kinds=(KINDS[0], KINDS[2], KINDS[3]), weights=(1, 1)),
    "masks": masked(random_model(meshes=True)),
    "nine masks, two layers, five maps": masked(layered_model(slots=5, expressions=7), 9),
    "one mask": masked(random_model(slots=1, meshes=True), 1),
}


@pytest.fixture(scope="module")
def gpu():
    with software() as context:
        yield Gpu(context)


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]
