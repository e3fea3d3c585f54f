"""What MetaHuman's and O3DE's materials make of an export, in plain numpy and from its files alone."""

import csv
import json

import numpy as np

from facezip.files.images import read_texture_exactly


def image(file):
    return read_texture_exactly(file).astype(np.float64) / 255


def linear(encoded):
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def encoded(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def sampled(texels, size):
    """Texels ``(h, w, C)`` at the texel centres of another size, bilinear and clamped."""
    for axis, count in enumerate(size):
        low = texels.shape[axis]
        at = np.clip((np.arange(count) + 0.5) * low / count - 0.5, 0, low - 1)
        first = np.floor(at).astype(int)
        part = (at - first).reshape([-1 if k == axis else 1 for k in range(texels.ndim)])
        second = np.minimum(first + 1, low - 1)
        texels = texels.take(first, axis) * (1 - part) + texels.take(second, axis) * part
    return texels


def vector(across, z):
    whole = np.concatenate([across * (1, -1), z[..., None]], axis=-1)
    return whole / np.linalg.norm(whole, axis=-1, keepdims=True)


def rebuilt(across):
    return np.sqrt(np.maximum(1 - (across**2).sum(axis=-1), 1e-6))


class MetaHuman:
    """``dx11_shd_head.fx``: changes from the neutral are added, each times a mask and a curve."""

    def __init__(self, folder):
        self.folder = folder
        self.curves = json.loads((folder / "curves.json").read_text(encoding="utf-8"))["curves"]
        with open(folder / "curves.csv", newline="", encoding="utf-8") as file:
            self.rows = {row.pop("expression"): row for row in csv.DictReader(file)}

    def weights(self, blend, layer):
        """Σ_k c_k M_k of a layer, by its file."""
        total = 0
        for name, curve in self.curves.items():
            if curve["map"] == layer:
                value = sum(beta * float(self.rows[expression][name]) for expression, beta in blend.items())
                total = total + value * image(self.folder / curve["mask"])
        return total

    def changes(self, blend, what, read):
        neutral = read(image(self.folder / f"head_{what}_map.png"))
        kind, total = "cm" if what == "color" else "wm", np.zeros_like(neutral)
        for number in (1, 2, 3):
            file = f"head_{kind}{number}_{what}_map.png"
            weights = sampled(self.weights(blend, file), neutral.shape[:2])
            total += weights * (read(image(self.folder / file)) - neutral)
        return neutral, total

    def albedo(self, blend):
        neutral, change = self.changes(blend, "color", linear)
        return encoded(neutral + change)

    def normal(self, blend):
        neutral, change = self.changes(blend, "normal", lambda texels: 2 * texels[..., :2] - 1)
        return vector(neutral + change, rebuilt(neutral))


class O3de:
    """``Skin_SurfaceEval.azsli``: masks of morph targets are added and clamped, layers are laid on in turn."""

    def __init__(self, folder):
        self.folder = folder
        self.material = json.loads((folder / "head.material").read_text(encoding="utf-8"))["propertyValues"]

    def mixed(self, blend, what, read):
        value = read(image(self.folder / self.material[f"{what}.textureMap"]))
        masks = sum(
            beta * sampled(image(self.folder / "head_wrinklemasks" / f"{name}_wrinklemask.tif"), value.shape[:2])
            for name, beta in blend.items()
        )
        factors = np.clip(masks, 0, 1) if blend else np.zeros((*value.shape[:2], 4))
        for number in range(self.material["wrinkleLayers.count"]):
            layer = read(image(self.folder / self.material[f"wrinkleLayers.{what}Map{number + 1}"]))
            value = value + factors[..., number, None] * (layer - value)
        return value

    def albedo(self, blend):
        return encoded(self.mixed(blend, "baseColor", linear))

    def normal(self, blend):
        across = self.mixed(blend, "normal", lambda texels: 2 * texels[..., :2] - 1)
        return vector(across, rebuilt(across))
