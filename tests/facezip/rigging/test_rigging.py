"""Example-based rigging: laws of its parts, and that scans improve on the template."""

import numpy as np
import pytest

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine import memory
from facezip.rigging.fit import fit_rig
from facezip.rigging.frames import Integrator, edges, frames, inverse_frames
from facezip.rigging.poses import pose_weights
from facezip.rigging.shapes import explain, trust
from facezip.rigging.transfer import transfer
from tests.facezip.rigging.case import make_case, sheet


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def rig(case):
    return fit(case)


def fit(case, unit=1.0):
    scans, template = case.scans, case.template
    moved = scans.meshes.vertices - scans.meshes.neutral
    lengths = (scans.meshes.neutral * unit, moved * unit, template.neutral * unit, template.deltas * unit)
    neutral, moved, other, shapes = (values.astype(np.float32) for values in lengths)
    return fit_rig(neutral, moved, scans.meshes.topology.faces, other, shapes)


def error(found, true):
    return np.linalg.norm(found - true, axis=2).mean() / np.linalg.norm(true, axis=2).mean()


def test_a_frame_times_its_inverse_is_one():
    vertices, topology = sheet()
    columns = edges(vertices, topology.faces)
    assert np.allclose(frames(columns) @ inverse_frames(columns), np.eye(3), atol=1e-9)


def test_a_frame_turns_and_grows_with_its_triangle():
    vertices, topology = sheet()
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    before, after = (frames(edges(points, topology.faces)) for points in (vertices, 2.5 * vertices @ turn.T))
    assert np.allclose(after, 2.5 * turn @ before, atol=1e-9)


def test_a_flat_triangle_has_no_inverse_frame():
    columns = edges(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 1, 3]]))
    assert not inverse_frames(columns)[0].any()
    assert inverse_frames(columns)[1].any()


def test_the_integrator_gives_back_the_displacements_of_their_edges(case):
    faces = case.scans.meshes.topology.faces
    integrator = Integrator(faces, ~case.deltas.any(axis=(0, 2)))
    sides = np.moveaxis(edges(case.deltas, faces), 0, 1)
    assert np.allclose(integrator(sides, case.deltas), case.deltas, atol=1e-5)


def test_shapes_transferred_to_their_own_neutral_stay_as_they_are(case):
    neutral, faces = case.scans.meshes.neutral, case.scans.meshes.topology.faces
    integrator = Integrator(faces, ~case.deltas.any(axis=(0, 2)))
    assert np.allclose(transfer(neutral, case.deltas, neutral, integrator).deltas, case.deltas, atol=1e-5)


def test_weights_of_known_shapes_are_found(case):
    moved = case.scans.meshes.vertices - case.scans.meshes.neutral
    found = pose_weights(case.deltas, moved, pull=1e-9)
    assert np.allclose(found, case.weights, atol=1e-3)


def test_weights_stay_between_nothing_and_all(case):
    moved = case.scans.meshes.vertices - case.scans.meshes.neutral
    found = pose_weights(case.deltas, np.concatenate([3 * moved, -moved]), pull=1e-9)
    assert found.min() >= 0
    assert found.max() <= 1


def test_one_element_is_the_least_squares_solution_of_its_equations():
    rng = np.random.default_rng(1)
    prior, strain = rng.standard_normal((1, 6, 3)), rng.uniform(0, 1, (1, 6))
    scans, alpha, beta = rng.standard_normal((1, 4, 3)), rng.uniform(0, 1, (4, 6)), 0.3
    found = explain(*(x.astype(np.float32) for x in (prior, strain, scans)), alpha, beta)
    held = beta * trust(strain.astype(np.float32))[0]
    straight = np.linalg.solve(alpha.T @ alpha + np.diag(held), alpha.T @ scans[0] + held[:, None] * prior[0])
    assert np.allclose(found[0], straight, atol=1e-4)


def test_scans_improve_on_the_template(case, rig):
    seen = rig.seen
    assert error(rig.deltas[seen], case.deltas[seen]) < 0.8 * error(rig.transferred[seen], case.deltas[seen])


def test_shapes_and_weights_explain_the_scans(case, rig):
    moved = case.scans.meshes.vertices - case.scans.meshes.neutral
    sizes = np.sqrt(np.mean(np.sum(moved**2, axis=2), axis=1))
    assert (rig.residuals < 0.1 * sizes).all()


def test_a_shape_in_no_scan_keeps_the_template_s_motion(case, rig):
    tongue = case.template.shapes.index("tongue")
    assert not rig.seen[tongue]
    assert np.allclose(rig.deltas[tongue], rig.transferred[tongue], atol=0.02)


def test_what_nothing_moves_rests_exactly(case, rig):
    still = ~case.deltas.any(axis=(0, 2))
    assert still.any()
    assert not rig.deltas[:, still].any()


def test_the_same_input_gives_the_same_bits(case, rig):
    again = fit(case)
    assert np.array_equal(again.deltas, rig.deltas)
    assert np.array_equal(again.weights, rig.weights)


def test_the_unit_of_the_meshes_does_not_matter(case, rig):
    millimetres = fit(case, 10.0)
    assert np.allclose(millimetres.weights, rig.weights, atol=1e-3)
    assert np.allclose(millimetres.deltas, 10 * rig.deltas, atol=1e-2)


def test_a_limit_of_memory_that_meshes_do_not_fit_in_names_the_least_that_works(case, tmp_path):
    with memory.limited(memory.LEAST, tmp_path), pytest.raises(FaceZipError, match=r"need \d+M at least") as refusal:
        fit(case)
    assert refusal.value.code is ErrorCode.BAD_VALUE
