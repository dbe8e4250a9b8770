import base64
import io
import json

import numpy as np
import pytest
from matplotlib.image import imread

from drake_ltl.visualization.text_plate import text_gltf


@pytest.mark.parametrize("text", ["a", "pi_1", "a_long_name_of_a_region"])
def test_plates_carry_everything_with_them(text):
    document = json.loads(text_gltf(text, 2.0, (0.0, 0.4, 0.8)))
    uris = [entry["uri"] for entry in (*document["images"], *document["buffers"])]
    assert all(uri.startswith("data:") for uri in uris)
    picture = imread(io.BytesIO(base64.b64decode(uris[0].partition(",")[2])))
    (buffer,) = document["buffers"]
    content = base64.b64decode(buffer["uri"].partition(",")[2])
    assert len(content) == buffer["byteLength"]
    corners = np.frombuffer(content, dtype=np.float32, count=12).reshape(4, 3)
    width, height, depth = np.ptp(corners, axis=0)
    assert (height, depth) == (2.0, 0.0)
    assert width / height == pytest.approx(picture.shape[1] / picture.shape[0], rel=0.02)  # whole pixels
    assert picture[0, 0, 3] == 0.0  # transparent at the corner
    strongest = picture[..., 3] == 1.0
    blue = np.abs(picture[strongest][:, :3] - (0.0, 0.4, 0.8)).max(axis=1) < 0.02
    assert blue.mean() > 0.1  # there are letters
