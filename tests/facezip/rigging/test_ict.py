"""Rigging on real production geometry, where it is at hand: it is not ours to ship."""

from pathlib import Path

import pytest

from tests.facezip.rigging.real_geometry import error, rig_from

FILE = Path(__file__).parents[4] / "shared/data/ict_facekit/ict_face.npz"


@pytest.mark.skipif(not FILE.is_file(), reason="needs ICT FaceKit beside the project")
def test_scans_of_a_real_face_improve_on_the_template():
    rig, deltas, _, _ = rig_from(FILE)
    assert error(rig.deltas, deltas) < min(0.25, error(rig.transferred, deltas))
