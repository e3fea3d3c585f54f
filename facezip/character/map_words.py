"""What programs call maps: the words in names of textures, whichever program wrote them, and the map that each means.

Words are compared in small letters and without what joins them: ``Base_Color``, ``base-color`` and ``BaseColor`` are
one. They are those of Substance Painter, Marmoset, Quixel, Unreal, Unity, Blender, glTF, Poly Haven, and of programs
for scans (RealityCapture, Metashape, Polycam, KeenTools, Wrap, light stages). Letters of several maps are not here.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from facezip.character.maps import ALBEDO

_COLOUR = r"albedos?|alb|base|basecolou?rs?|basecol|bc|colou?rs?|col|c|d|diffuse|diff|dif|maintex"
_ALBEDO = rf"(?:{_COLOUR}|diffuse(?:colou?r|albedo)|albedo(?:diffuse|transparency))"
_NORMAL = r"(?:(?:diffuse|specular|tangent|tangentspace|ts)?(?:normals?|nrml?|norm?|nml|nm|n))"
_UP, _DOWN = r"(?:gl|ogl|opengl|yup)", r"(?:dx|d3d|directx|ydown)"
_MAP = r"(?:maps?|tex|texture)?"
_TAKEN = (
    (ALBEDO, None, rf"{_ALBEDO}{_MAP}"),
    ("normal", False, rf"{_NORMAL}{_MAP}{_UP}|{_UP}{_NORMAL}{_MAP}"),
    ("normal", True, rf"{_NORMAL}{_MAP}{_DOWN}|{_DOWN}{_NORMAL}{_MAP}"),
    ("normal", None, rf"{_NORMAL}{_MAP}"),
    ("roughness", None, rf"(?:roughness|rough|rgh|rghn|rou|r){_MAP}"),
    ("specular", None, rf"(?:specular|spec|spc|specular(?:level|albedo|intensity)|speclevel){_MAP}"),
    ("cavity", None, rf"(?:cavity|cav|cvt|cvty){_MAP}"),
)
# Maps that nothing here takes, by the words that a person reads of them.
_LEFT_OUT = (
    ("ambient occlusion", rf"(?:ao|mixedao|ambientocclusion|ambient|occlusion|occ|occl){_MAP}2?"),
    (
        "displacement",
        rf"(?:heights?|hgt|h|bumps?|b|v?dpm?|vdm|(?:micro|macro|vector|v)?(?:displacements?|displaced?|displ|disps?|dsp))"
        rf"{_MAP}",
    ),
    ("depth", rf"z?depths?{_MAP}"),
    ("metal", rf"(?:metallic|metalness|metal|mtl|met|m){_MAP}"),
    ("emission", rf"(?:emissive|emission|emit|glow|e){_MAP}"),
    ("opacity", rf"(?:opacity|opac|alpha|transparency|transmission|o){_MAP}"),
    (
        "scattering",
        rf"(?:sss|subsurface|scatter(?:ing)?(?:colou?r)?|translucency|translucent|thickness|fuzz){_MAP}",
    ),
    ("curvature", rf"(?:curvature|curve|curv|convexity|concavity|concave|convex){_MAP}"),
    ("an identity", rf"(?:id|matid|objid|objectid|materialid|colou?rid|uv|uvs|uvisland|wireframe|wire){_MAP}"),
    ("positions", rf"(?:position|pos|(?:world|ws|object|obj|bent|os)(?:space)?normals?|normalobj){_MAP}"),
    ("gloss, the opposite of roughness", rf"(?:gloss|glossiness|gls|smoothness|smooth){_MAP}"),
    (
        "several maps in one image",
        r"orm|arm|mra|rma|rmo|mro|orh|ordp|mask_?map|occlusionroughness(?:metallic|metalness)|metallic(?:roughness|gloss"
        r"|smoothness)(?:map)?|rough(?:ness)?metal(?:lic|ness)?",
    ),
)
# Words that say nothing of the map: Unreal's for a texture, resolutions, levels of detail, the colour space of files.
_NOTHING = re.compile(
    r"t|tx|tex|txt|texture|textures|map|maps|\d{1,2}k|\d{3,5}x\d{3,5}|512|1024|2048|4096|8192|16384|lod\d|srgb"
)
# Colour spaces that names state, each in one word or two; a file that states nothing itself is read in none of them.
_OTHER_SPACE = re.compile(
    r"aces(?:cg|cct|cc|20651?)?|adobergb|(?:display|dci)p3|(?:lin)?(?:rec|bt)(?:709|2020|2100)|prophoto(?:rgb)?|romm(?:rgb)?"
    r"|lin(?:ear)?(?:srgb)?|scenelinear|logc\d?|slog\d"
)
# Words of folders of pictures, which hold the albedo where nothing else is said.
_PICTURES = re.compile(r"textures?|tex|images?|imgs?|pictures?|photos?|skin")
# So do these where no other word stands beside them.
_FILES = re.compile(r"udims?|tiles?|(?:png|jpe?g|tiff?|exr|tga|bmp|webp)s?")


@dataclass(frozen=True)
class MapWord:
    """What words say.

    Attributes
    ----------
    map : of :data:`facezip.character.maps.KNOWN`; "" for one that is left out.
    says : in words for people; of a map that is left out, what it holds.
    green_down : of normals, whether y is down; None where nothing is said.
    guessed : whether nothing says it: such images are of the albedo where there is no other.
    """

    map: str
    says: str
    green_down: bool | None = None
    guessed: bool = False


def meant(words: Sequence[str]) -> MapWord | None:
    """The map that words of a name mean, in small letters and without what joins them; None where they say no map."""
    joined = "".join(word for word in words if not _NOTHING.fullmatch(word))
    for map, green_down, pattern in _TAKEN:
        if re.fullmatch(pattern, joined):
            return MapWord(map, map, green_down)
    for says, pattern in _LEFT_OUT:
        if re.fullmatch(pattern, joined):
            return MapWord("", says)
    return None


def says_nothing(words: Sequence[str]) -> bool:
    """Whether words of a name say nothing of a map."""
    return all(map(_NOTHING.fullmatch, words))


def other_space(words: Sequence[str]) -> tuple[str, ...]:
    """Those of the words of a name that state a colour space other than sRGB."""
    together = [*((word,) for word in words), *pairwise(words)]
    return tuple(dict.fromkeys(word for some in together if _OTHER_SPACE.fullmatch("".join(some)) for word in some))


def meant_by_folder(words: Sequence[str]) -> MapWord:
    """The map of images that are called as meshes are, by their folder's name; the albedo where that is of pictures."""
    if (said := meant(words)) is not None:
        return said
    each = [said for word in words if len(word) > 1 and not _PICTURES.fullmatch(word) and (said := meant((word,)))]
    others = [said for said in each if said.map != ALBEDO]
    if others and not any(other.map for other in others):
        return others[0]
    of_pictures = bool(each) or any(map(_PICTURES.fullmatch, words))
    of_files = all(_FILES.fullmatch(word) or _NOTHING.fullmatch(word) for word in words)
    return MapWord(ALBEDO, ALBEDO, guessed=bool(others) or not (of_pictures or of_files))
