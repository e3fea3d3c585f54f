from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import ALBEDO, KNOWN, normals_of
from facezip.character.scans import Stack
from facezip.files.images import to_float
from facezip.files.srgb import decode_srgb
from facezip.fit.methods import compress
from render.effect import image_errors
from render.importance import Sight, posed, regularised, seen_importance, staged_albedo
from render.metrics import display
from render.sensitivity import squared_error_weight
from render.skins import RENDERED, upload
from render.staging import staged, staged_original
from scenes.cameras import VIEWS
from scenes.tiles import in_tiles

FRONT = ((VIEWS[0], "daylight"),)


@pytest.fixture(scope="module")
def sight():
    return Sight(FRONT, resolution=48, spp=16, material="diffuse")


@pytest.fixture(scope="module")
def seen(character, sight):
    return seen_importance(character, sight)[ALBEDO, 1001]


@pytest.fixture(scope="module")
def tiled(character):
    """The ball with normals and roughness, its chart cut into two tiles."""
    return in_tiles(with_maps(character), 2, 1)


def with_maps(character):
    """With maps of little relief and of a roughness that changes."""
    stacks = dict(character.stacks)
    texels = {name: to_float(getattr(character.first, name)) for name in ("neutral", "textures")}
    flat = {name: 0.5 + 0.02 * (some[..., :2] - 0.5) for name, some in texels.items()}
    stacks["normal", 1001] = Stack(**{name: np.rint(some * 65535).astype(np.uint16) for name, some in flat.items()})
    stacks["roughness", 1001] = Stack(**{name: np.ascontiguousarray(some[..., 2:]) for name, some in texels.items()})
    kinds = tuple(KNOWN[name] for name in ("albedo", "normal", "roughness"))
    return replace(character, maps=kinds, stacks=stacks)


@pytest.fixture(scope="module")
def operator(character, sight):
    renderer = sight.renderer(character)
    return next(sight.operators(renderer, posed(character, renderer, "smile")))


def squared_image_error(operator, encoded, other):
    head = operator.coverage >= 0.5
    shown = [display(operator.image(decode_srgb(texture)))[head].astype(np.float64) for texture in (encoded, other)]
    return np.square(shown[0] - shown[1]).mean()


def test_it_is_zero_exactly_where_no_camera_sees_a_texel(character, sight, seen):
    renderer = sight.renderer(character)
    looked_up = np.zeros(character.first.resolution)
    for name in character.expressions:
        for operator in sight.operators(renderer, posed(character, renderer, name)):
            head = np.repeat(operator.coverage[:, :, None] >= 0.5, 3, axis=2)
            looked_up += operator.transposed(head.astype(np.float32)).sum(axis=2)
    np.testing.assert_array_equal(seen > 0, looked_up > 0)
    assert 0.2 < (seen > 0).mean() < 0.8


def test_the_back_of_the_head_is_what_is_not_seen(seen):
    # The ball's u is 0.5 in front.
    assert (seen[16:48, 24:40] > 0).all()
    assert (seen[:, :4] == 0).all()


def test_equal_errors_in_all_texels_make_the_image_error_that_it_predicts(character, operator):
    encoded = character.texture("smile") * 0.8 + 0.1
    weight = squared_error_weight(operator, encoded)
    error = 1e-3
    actual = squared_image_error(operator, encoded, encoded + np.float32(error))
    assert error**2 * weight.sum() == pytest.approx(actual, rel=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_it_bounds_the_image_error_of_any_small_error(character, operator, seed):
    encoded = character.texture("smile") * 0.8 + 0.1
    weight = squared_error_weight(operator, encoded)
    # The weight is the sum over channels: errors alike in all of them.
    error = 1e-3 * np.random.default_rng(seed).normal(size=(*weight.shape, 1)).astype(np.float32)
    actual = squared_image_error(operator, encoded, encoded + error)
    assert 0 < actual < 1.02 * (weight * error[:, :, 0] ** 2).sum()


def test_it_repeats(character, sight, seen):
    np.testing.assert_array_equal(seen_importance(character, sight)[ALBEDO, 1001], seen)


def test_it_adds_up_over_looks(character, sight, seen):
    side = ((VIEWS[4], "daylight"),)
    both = seen_importance(character, replace(sight, looks=FRONT + side))
    alone = seen_importance(character, replace(sight, looks=side))
    np.testing.assert_allclose(both[ALBEDO, 1001], seen + alone[ALBEDO, 1001], rtol=1e-5, atol=1e-12)


def test_tiles_have_the_parts_of_the_whole(tiled, character, sight):
    whole, found = seen_importance(with_maps(character), sight), seen_importance(tiled, sight)
    assert set(found) == set(tiled.stacks)
    for name in (ALBEDO, "normal", "roughness"):
        parts = np.concatenate([found[name, 1001], found[name, 1002]], axis=1)
        np.testing.assert_allclose(parts, whole[name, 1001], rtol=1e-3, atol=1e-4 * whole[name, 1001].max())


@pytest.mark.parametrize("seed", range(2))
def test_it_is_exact_for_the_albedo_among_other_maps(tiled, sight, seed):
    """Images of a shiny skin with normals and roughness: equal errors make the error that it predicts, others less."""
    shiny = replace(sight, material="skin")
    renderer = shiny.renderer(tiled)
    operator = next(shiny.operators(renderer, posed(tiled, renderer, "smile")))
    encoded, name = staged_albedo(tiled, "smile") * np.float32(0.8) + np.float32(0.1), "smile"
    weight = squared_error_weight(operator, encoded)
    equal = np.full(weight.shape, 1e-3, np.float32)
    varied = 1e-3 * np.random.default_rng(seed).normal(size=weight.shape).astype(np.float32)
    maps = staged_original(tiled)(name)
    skins = [upload(replace(maps, albedo=encoded + error[:, :, None])) for error in (0 * equal, equal, varied)]
    images = renderer.render(skins, *FRONT[0], shiny.spp, shiny.seed)
    right, *others = display(images.linear[:, images.coverage >= 0.5]).astype(np.float64)
    actual = [np.square(other - right).mean() for other in others]
    assert (weight * equal**2).sum() == pytest.approx(actual[0], rel=0.03)
    assert 0 < actual[1] < 1.03 * (weight * varied**2).sum()


def test_relief_changes_in_how_much_light_a_texel_is(tiled, sight):
    alone, among = (seen_importance(one, sight)[ALBEDO, 1002] for one in (tiled.only("albedo"), tiled))
    np.testing.assert_array_equal(alone > 0, among > 0)
    assert not np.allclose(alone, among, rtol=0.01)


@pytest.fixture(scope="module")
def shiny(character, sight):
    """A skin with all the maps that light meets, and how it is looked at."""
    scans = with_maps(character)
    stacks = dict(scans.stacks)
    for name in ("specular", "cavity"):
        stacks[name, 1001] = stacks["roughness", 1001]
    kinds = tuple(KNOWN[name] for name in RENDERED)
    return replace(scans, maps=kinds, stacks=stacks), replace(sight, material="skin", spp=64)


@pytest.mark.parametrize("name", ["normal", "roughness", "specular", "cavity"])
def test_slopes_are_what_an_image_makes_of_a_small_change(shiny, name):
    """Of a map, texel by texel, in linear light: against the difference of two renders of the same samples.

    Apart from few pixels at the silhouette, where relief turns to the light or away from it.
    """
    scans, look = shiny
    renderer = look.renderer(scans)
    channels = next(look.slopes(renderer, posed(scans, renderer, "smile")))[name]
    maps = staged_original(scans)("smile")
    rng, size, change = np.random.default_rng(1), getattr(maps, name).shape[:2], 2e-3
    for channel, matrices in enumerate(channels):
        error = change * rng.random(size, dtype=np.float32)
        other = replace(maps, **{name: changed(getattr(maps, name), name, channel, error)})
        images = renderer.render([upload(maps), upload(other)], *FRONT[0], look.spp, look.seed).linear
        found = np.stack([matrix @ error.ravel() for matrix in matrices], axis=1).reshape(images[0].shape)
        actual = images[1] - images[0]
        squares, gaps = (np.sort(np.square(some).sum(axis=2).ravel())[:-20] for some in (actual, found - actual))
        assert squares.sum() > 0
        assert gaps.sum() < 0.1**2 * squares.sum()


def changed(values, name, channel, error):
    """A map with one of its channels, or of its slopes, larger by ``(H, W)``."""
    if name != "normal":
        return values + error[:, :, None]
    slopes = values[..., :2] / values[..., 2:]
    slopes[..., channel] += error
    return normals_of(slopes)


@pytest.mark.parametrize("name", ["normal", "roughness"])
def test_the_weight_bounds_the_image_error_of_small_errors_of_any_map(shiny, name):
    scans, look = shiny
    one = replace(scans, expressions=("smile",), stacks={key: first_of(stack) for key, stack in scans.stacks.items()})
    weight, kind = seen_importance(one, look)[name, 1001], scans.kind(name)
    renderer, key = look.renderer(one), (name, 1001)
    renderer.pose(one.mesh_vertices("smile"))
    # Of texels; slopes span twenty times as much.
    error = (4e-3 / kind.unit) * np.random.default_rng(2).normal(size=one.stacks[key].neutral.shape)

    def texels(expression, where):
        right = to_float(one.texels(expression, where))
        return right + error.astype(np.float32) if where == key else right

    skins = [upload(staged(one, some)("smile")) for some in (one.texels, texels)]
    images = renderer.render(skins, *FRONT[0], look.spp, look.seed)
    right, wrong = display(images.linear[:, images.coverage >= 0.5]).astype(np.float64)
    assert 0 < np.square(wrong - right).mean() < 1.1 * (weight[:, :, None] * error**2).sum()


def first_of(stack):
    return Stack(stack.neutral, stack.textures[:1])


def test_a_matte_skin_has_no_importance_of_its_roughness(tiled, sight):
    seen = seen_importance(tiled, sight)
    assert not seen["roughness", 1001].any()
    inside = {key: np.ones_like(one) for key, one in seen.items()}
    assert {name for name, _ in regularised(seen, inside)} == {ALBEDO, "normal"}


def test_a_coarser_tile_has_the_sum_of_its_texels(tiled, sight):
    """Its texels are as many times larger on the screen."""
    few = tiled.only("albedo")
    coarse = replace(few, stacks={**few.stacks, ("albedo", 1002): halved(few.stacks["albedo", 1002])})
    fine, found = (seen_importance(one, sight)[ALBEDO, 1002] for one in (few, coarse))
    assert found.shape == (32, 16)
    assert found.sum() == pytest.approx(fine.sum(), rel=0.03)
    sums = fine.reshape(32, 2, 16, 2).sum(axis=(1, 3))
    np.testing.assert_allclose(found, sums, atol=0.1 * sums.max())


def halved(stack):
    means = {
        name: getattr(stack, name).reshape(*shape, 32, 2, 16, 2, 3).mean(axis=(-4, -2)).round().astype(np.uint8)
        for name, shape in (("neutral", ()), ("textures", (len(stack.textures),)))
    }
    return Stack(**means)


def test_the_floor_is_what_an_unseen_texel_counts(seen):
    mask = np.ones_like(seen)
    mask[:8] = 0
    halves = {(ALBEDO, 1001): slice(0, 20), (ALBEDO, 1002): slice(20, None)}
    found = regularised(*({key: some[rows] for key, rows in halves.items()} for some in (seen, mask)), 0.25)
    weight = np.concatenate([*found.values()])
    assert np.average(weight, weights=mask) == pytest.approx(1, rel=1e-5)
    np.testing.assert_array_equal(weight[seen == 0], np.float32(0.25))


def test_a_floor_of_one_ignores_the_cameras(seen):
    key, ones = (ALBEDO, 1001), np.ones_like(seen)
    np.testing.assert_allclose(regularised({key: seen}, {key: ones}, 1)[key], 1, rtol=1e-6)


def test_further_maps_count_beside_the_albedo_as_much_as_they_show(seen):
    ones, other = np.ones_like(seen), ("normal", 1001)
    weights = regularised({(ALBEDO, 1001): seen, other: 5 * seen}, {(ALBEDO, 1001): ones, other: ones}, 0.25)
    np.testing.assert_allclose(weights[other], 5 * weights[ALBEDO, 1001], rtol=1e-5)


def test_a_fit_with_it_lowers_the_weighted_error(character, seen):
    key = (ALBEDO, 1001)
    importance = regularised({key: seen}, {key: np.ones_like(seen)}, 0.05)[key]
    errors = []
    for weight in (None, importance):
        model = compress(character, differences=1, weight_scale=32, importance=weight)
        gaps = [model.reconstruct(name) - character.texture(name) for name in character.expressions]
        errors.append(sum(float((importance[:, :, None] * gap**2).sum()) for gap in gaps))
    assert errors[1] < errors[0]


def test_a_character_has_no_image_error_to_itself_and_more_to_worse_maps(tiled, sight):
    """Whichever of its maps is worse; of a matte skin, roughness does not count."""

    def off(by, worse):
        def texels(name, key):
            right = to_float(tiled.texels(name, key))
            return np.clip(right + np.float32(by), 0, 1) if key[0] == worse else right

        return staged(tiled, texels)

    shiny = replace(sight, material="skin")
    for worse, by in (("albedo", 0.01), ("normal", 0.0005), ("roughness", 0.1)):
        skins = [staged(tiled, tiled.texels), off(by, worse), off(3 * by, worse)]
        none, small, large = image_errors(tiled, skins, shiny)[:, :, 0]
        assert (none == 0).all()
        assert (small > 0.05).all()
        assert (large > 1.5 * small).all()
