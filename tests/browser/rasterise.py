"""Where a mesh is seen: faces and texture coordinates at pixel centres, by a z-buffer that has nothing of WebGL."""

import numpy as np
from numba import njit


def seen_uv(vertices, topology, projection, view, size, subpixel_bits):
    """The front-most triangle ``(H, W)`` and perspective-correct UV ``(H, W, 2)`` on it; -1 and NaN without one.

    Parameters
    ----------
    vertices : ``(V, 3)``.
    view, projection : ``(4, 4)``, from the world to the camera, and from there to clip space; applied in 32 bits.
    size : rows and columns.
    subpixel_bits : a GPU places vertices on a grid of 2^-bits pixels (SUBPIXEL_BITS of OpenGL).
    """
    world = np.c_[vertices, np.ones(len(vertices))].astype(np.float32)
    clip = world @ view.T.astype(np.float32) @ projection.T.astype(np.float32)
    height, width = size
    screen = (clip[:, :2] / clip[:, 3:] * [0.5, -0.5] + 0.5) * [width, height]
    screen = np.rint(screen * 2**subpixel_bits) / 2**subpixel_bits
    depth = np.full(size, np.inf)
    face, uv = np.full(size, -1), np.full((*size, 2), np.nan)
    _fill(screen, clip[:, 3], topology.faces, topology.uv.astype(float), topology.face_uv, depth, face, uv)
    return face, uv


@njit(cache=True)
def _fill(screen, w, faces, coordinates, face_uv, depth, face, uv):
    for f in range(len(faces)):
        a, b, c = faces[f]
        (ax, ay), (bx, by), (cx, cy) = screen[a], screen[b], screen[c]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        for y in range(max(0, int(min(ay, by, cy) - 0.5)), min(len(depth) - 1, int(max(ay, by, cy) + 0.5)) + 1):
            for x in range(max(0, int(min(ax, bx, cx) - 0.5)), min(depth.shape[1] - 1, int(max(ax, bx, cx) + 0.5)) + 1):
                px, py = x + 0.5, y + 0.5
                p = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area / w[a]
                q = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area / w[b]
                r = ((ax - px) * (by - py) - (ay - py) * (bx - px)) / area / w[c]
                near = p + q + r
                if min(p, q, r) >= 0 and 1 / near < depth[y, x]:
                    depth[y, x] = 1 / near
                    face[y, x] = f
                    i, j, k = face_uv[f]
                    uv[y, x] = (p * coordinates[i] + q * coordinates[j] + r * coordinates[k]) / near
