"""Where each map is among the textures, and what was measured of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from facezip.character.maps import Encoding
from facezip.export.documents.textures import Size


@dataclass(frozen=True, kw_only=True)
class CodecErrors:
    """What blocks add to expressions: RMSE of 255, of normals mean angles in degrees.

    Attributes
    ----------
    name : of the codec.
    rmse, angular_error : mean over expressions.
    rmse_per_expression, angular_error_per_expression : by expression.
    rmse_without_fit, angular_error_without_fit : without fitting each texture to what was lost of the others.
    maps : what storing lost of each texture.
    """

    name: str
    rmse: float | None = None
    rmse_per_expression: Mapping[str, float] | None = None
    rmse_without_fit: float | None = None
    angular_error: float | None = None
    angular_error_per_expression: Mapping[str, float] | None = None
    angular_error_without_fit: float | None = None
    maps: Mapping[str, float] | None = None


@dataclass(frozen=True, kw_only=True)
class MipErrors:
    """How far one level of mip-maps is from how a blend should look from afar; ``_blends`` of unseen blends.

    Attributes
    ----------
    size : rows and columns of the level.
    product_gap, product_gap_blends : how far the mean of a blend's texels is from the blend of plain mip-maps.
    plain, plain_blends : every texture averaged on its own, stored as it is.
    averaged, averaged_blends : the same in blocks.
    fitted, fitted_blends : in blocks and fitted, as written.
    """

    size: Size
    product_gap: float
    product_gap_blends: float | None = None
    plain: float
    plain_blends: float | None = None
    averaged: float | None = None
    averaged_blends: float | None = None
    fitted: float | None = None
    fitted_blends: float | None = None


@dataclass(frozen=True, kw_only=True)
class ExportedMap:
    """Where a map is.

    Attributes
    ----------
    encoding, range : what its numbers stand for, and the values of texels of 0 and 1.
    size : rows and columns.
    neutral, differences : names among the textures.
    channels : its own in those.
    max_slope : slopes of normals are clipped to this, either way.
    codec : of blocks.
    mips : level by level.
    """

    encoding: Encoding
    range: tuple[float, float]
    size: Size
    neutral: str
    differences: Sequence[str]
    channels: Sequence[int]
    max_slope: float | None = None
    codec: CodecErrors | None = None
    mips: Sequence[MipErrors]
