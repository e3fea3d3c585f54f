"""What is sampled has the density that it is divided by: Mitsuba's chi-square tests on our own samplers."""

import numpy as np
import pytest

from render.lighting import Lights
from render.llvm import start
from render.points import Points
from render.shading import SHADINGS, Finish
from scenes.cameras import Frame
from scenes.lights import RIGS

COUNT = 1_000_000
# Each law has to hold at a level that a sound sampler misses once in a thousand suites.
LEVEL = 1e-3
# No bounce weighs more.
BOUND = 4.0


def chi_square(domain, sample, density, dimension, res, ires=4):
    """The p-value of Mitsuba's test; 0 where it finds samples that there cannot be."""
    from mitsuba.chi2 import ChiSquareTest

    test = ChiSquareTest(domain, sample, density, sample_dim=dimension, sample_count=COUNT, res=res, ires=ires)
    test.run(quiet=True)
    return 0.0 if test.fail else float(test.p_value)


class Drawn:
    """Numbers that a sequence gives one by one."""

    def __init__(self, *numbers):
        self._numbers = iter(numbers)

    def next_float32(self):
        return next(self._numbers)


def bounces(material, turn, finish, found):
    """Light that leaves half grey skin as our paths do, weighted to the BSDF of ``finish``, against that of ``found``.

    ``turn`` is the angle from the normal to the eye; beyond a right one the mesh is seen from behind.
    """
    start()
    import drjit as dr
    import mitsuba as mi
    from mitsuba.chi2 import SphericalDomain

    points = Points(mi.load_dict({"type": "scene", "ball": {"type": "sphere"}}), SHADINGS[material])

    def seen(count):
        point = dr.zeros(mi.SurfaceInteraction3f, count)
        point.sh_frame, point.t = mi.Frame3f(mi.Vector3f(0, 0, 1)), mi.Float(1)
        point.wi = mi.Vector3f(float(np.sin(turn)), 0.0, float(np.cos(turn)))
        return point

    def reflected(light, finish):
        """The BSDF, times the cosine, of directions to the light."""
        diffuse, specular = points.shaded(seen(dr.width(light)), light, finish)
        return 0.5 * diffuse + specular

    def sample(numbers):
        direction, density, _ = points.leaving(seen(dr.width(numbers)), Drawn(numbers.x, numbers.y))
        weight = dr.select(density > 0, reflected(direction, finish) / density, 0)
        assert float(np.array(dr.max(weight)).item()) <= BOUND
        # Kept or not, by chance: counts are what the test is of.
        return direction, dr.select(numbers.z * BOUND < weight, mi.Float(1), mi.Float(0))

    return chi_square(SphericalDomain(), sample, lambda light: reflected(light, found) / BOUND, 3, res=21)


# A finish, and one that differs from it by as little as a slip would.
FINISHES = [(Finish(), Finish(roughness=0.6)), (Finish(roughness=0.6, specular=0.8), Finish(roughness=0.6))]


@pytest.mark.parametrize("turn", [0.2, 0.9, 2.5])
@pytest.mark.parametrize(("finish", "slip"), FINISHES)
def test_bounces_off_skin_are_weighted_to_its_bsdf(turn, finish, slip):
    assert bounces("skin", turn, finish, finish) > LEVEL
    assert bounces("skin", turn, finish, slip) < LEVEL


@pytest.mark.parametrize("turn", [0.2, 0.9, 2.5])
def test_bounces_off_matte_skin_are_weighted_to_its_bsdf(turn):
    assert bounces("diffuse", turn, Finish(), Finish()) > LEVEL
    assert bounces("diffuse", turn, Finish(), Finish(cavity=0.8)) < LEVEL


@pytest.fixture(scope="module")
def frame():
    return Frame(centre=(0.0, 0.0, 0.0), height=2.0)


def lit(lights, frame):
    """From uniform numbers to directions to a light, of a point in the middle of the frame."""
    import drjit as dr
    import mitsuba as mi

    nothing = mi.load_dict({"type": "scene"})

    def directions(numbers):
        point = dr.zeros(mi.SurfaceInteraction3f, dr.width(numbers))
        point.p, point.t = mi.Point3f(*frame.centre), mi.Float(1)
        point.n, point.sh_frame, point.wi = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Vector3f(0, 0, 1)), mi.Vector3f(0, 0, 1)
        found, _ = lights.sample(nothing, point, mi.Point2f(numbers.x, numbers.y), mi.Bool(True))
        return found

    return directions


def test_the_sky_is_sampled_by_its_density(frame):
    start()
    import drjit as dr
    import mitsuba as mi
    from mitsuba.chi2 import SphericalDomain

    sky = mi.load_dict({"type": "scene", **RIGS["daylight"](frame)}).emitters()[0]

    def density(direction):
        sample = dr.zeros(mi.DirectionSample3f, dr.width(direction))
        sample.d = direction
        return sky.pdf_direction(dr.zeros(mi.SurfaceInteraction3f, dr.width(direction)), sample)

    assert chi_square(SphericalDomain(), lit(Lights("daylight", frame), frame), density, 2, res=31, ires=12) > LEVEL


@pytest.mark.parametrize("rig", ["studio", "side"])
def test_softboxes_are_sampled_by_their_weights_and_evenly(frame, rig):
    """A rectangle is drawn evenly over its area: in the plane of (light, u) x v the density is a light's share."""
    start()
    import drjit as dr
    import mitsuba as mi
    from mitsuba.chi2 import PlanarDomain

    parts = RIGS[rig](frame)
    shapes = [mi.load_dict({"type": "scene", "light": parts[name]}) for name in sorted(parts)]
    weights = np.array([parts[name]["emitter"]["sampling_weight"] for name in sorted(parts)])
    shares = weights / weights.sum()
    directions = lit(Lights(rig, frame), frame)

    def place(numbers):
        found = directions(numbers)
        spot = mi.Point2f(-1, -1)
        for k, shape in enumerate(shapes):
            hit = shape.ray_intersect(mi.Ray3f(mi.Point3f(*frame.centre), found))
            spot = dr.select(hit.is_valid(), mi.Point2f(hit.uv.x + k, hit.uv.y), spot)
        return mi.Vector2f(spot)

    def density(of):
        return lambda spot: dr.gather(mi.Float, mi.Float(of.tolist()), mi.UInt32(spot.x))

    domain = PlanarDomain(mi.ScalarBoundingBox2f([0, 0], [len(parts), 1]))
    # So many rows that no cell is of two lights.
    res = 4 * len(parts) ** 2
    assert chi_square(domain, place, density(shares), 2, res=res) > LEVEL
    assert chi_square(domain, place, density(np.roll(shares, 1)), 2, res=res) < LEVEL
