"""Text for Meshcat, which has none: a flat plate with a picture of the text, as glTF in memory."""

from __future__ import annotations

import base64
import io
import json

import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from drake_ltl.visualization.palette import Colour

PIXELS = 128
"""Height of the picture."""
HALO = 0.16
"""Width of the white outline as a share of the letters' size."""


def text_gltf(text: str, height: float, colour: Colour) -> str:
    """A glTF 2.0 document: a plate `height` m high, centred at the origin, that faces +z and reads along +x.

    Nothing in it refers to another file. The picture is not shaded by lights, and is transparent around the letters.
    glTF's own axes (y up, z towards the reader) are meant: a viewer whose z axis points up shows the plate standing.
    """
    picture, aspect = _picture(text, colour)
    half_width, half_height = 0.5 * height * aspect, 0.5 * height
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float32)
    positions = np.zeros((4, 3), dtype=np.float32)
    positions[:, :2] = corners * np.array([half_width, half_height], dtype=np.float32)
    texture = np.stack([(corners[:, 0] + 1) / 2, (1 - corners[:, 1]) / 2], axis=1).astype(np.float32)
    indices = np.array([0, 1, 2, 0, 2, 3], dtype=np.uint16)
    parts = [positions.tobytes(), texture.tobytes(), indices.tobytes()]
    offsets = np.cumsum([0] + [len(part) for part in parts])
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "extensionsUsed": ["KHR_materials_unlit"],
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [
                {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}
            ],
            "materials": [
                {
                    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
                    "alphaMode": "BLEND",
                    "doubleSided": True,
                    "extensions": {"KHR_materials_unlit": {}},
                }
            ],
            "textures": [{"source": 0}],
            "images": [{"uri": _data_uri("image/png", picture)}],
            "accessors": [
                {
                    "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                    "min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist(),
                },
                {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
            ],
            "bufferViews": [
                {"buffer": 0, "byteOffset": int(begin), "byteLength": len(part)}
                for begin, part in zip(offsets, parts, strict=False)
            ],
            "buffers": [
                {"byteLength": int(offsets[-1]), "uri": _data_uri("application/octet-stream", b"".join(parts))}
            ],
        }
    )  # fmt: skip


def _picture(text: str, colour: Colour) -> tuple[bytes, float]:
    """A PNG of the text with a white outline, and its width over its height."""
    path = TextPath((0, 0), text, size=1.0, prop=FontProperties(family="DejaVu Sans", weight="bold"))
    extents = path.get_extents()
    low, high = -0.24 - HALO, 0.76 + HALO  # the same for all texts, so that all letters are of one size
    width = extents.width + 2 * HALO
    aspect = width / (high - low)
    figure = Figure(figsize=(aspect, 1.0), dpi=PIXELS)
    figure.patch.set_alpha(0.0)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set(xlim=(0, width), ylim=(low, high))
    moved: Path = path.transformed(Affine2D().translate(HALO - extents.x0, 0))
    axes.add_patch(PathPatch(moved, fc="white", ec="white", lw=HALO * 72 / (high - low), joinstyle="round"))
    axes.add_patch(PathPatch(moved, fc=colour, lw=0))
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=PIXELS, transparent=True, metadata={"Software": None})
    return stream.getvalue(), aspect


def _data_uri(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
