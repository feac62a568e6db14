"""Reads flight.mcap by other authors' reader, and holds it against fixes.csv of the same flight.

    python3 tests/recording/read.py FOLDER

FOLDER holds both. Needs mcap and jsonschema.
"""

import base64
import csv
import json
import math
import sys
from pathlib import Path

import jsonschema
from mcap.reader import make_reader

folder = Path(sys.argv[1])
with open(folder / "fixes.csv", newline="", encoding="utf-8") as file:
    frames = list(csv.DictReader(file))
topics = {}
with open(folder / "flight.mcap", "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    summary = reader.get_summary()
    for schema, channel, message in reader.iter_messages():
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json"), channel
        content = json.loads(message.data)
        rules = json.loads(schema.data)
        jsonschema.validate(content, rules)
        # The schema lists every field that there is, so that nothing escapes it.
        assert set(content) <= set(rules["properties"]), (set(content), schema.name)
        assert rules["title"] == schema.name
        topics.setdefault((channel.topic, schema.name), []).append((message.log_time, content))

assert summary.statistics.message_count == sum(map(len, topics.values()))
fixed = [frame for frame in frames if frame["accepted"] == "1"]
wanted = {
    ("/map/image", "foxglove.CompressedImage"): 1,
    ("/tf", "foxglove.FrameTransform"): len(frames),
    ("/truth", "foxglove.LocationFix"): len(frames),
    ("/fix", "foxglove.LocationFix"): len(fixed),
    ("/fix/ellipse", "foxglove.SceneUpdate"): len(fixed),
}
for topic, count in wanted.items():
    assert len(topics.get(topic, [])) == count, (topic, count, {topic: len(of) for topic, of in topics.items()})
assert len(topics.get(("/log", "foxglove.Log"), [])) == len(frames) - len(fixed)
images = topics[("/camera/image", "foxglove.CompressedImage")] + topics[("/map/image", "foxglove.CompressedImage")]
assert len(images) > 2 and all(base64.b64decode(image["data"]).startswith(b"\x89PNG") for _, image in images)

for frame, (_, fix), (_, scene) in zip(
    fixed, topics[("/fix", "foxglove.LocationFix")], topics[("/fix/ellipse", "foxglove.SceneUpdate")]
):
    sigmas = [float(frame["sigma_east_m"]), float(frame["sigma_north_m"])]
    covariance = fix["position_covariance"]
    assert all(math.isclose(covariance[4 * i], sigmas[i] ** 2, rel_tol=1e-9) for i in range(2)), (frame, fix)
    assert covariance[1] == covariance[3] and fix["position_covariance_type"] == 3
    # The ellipse's axes by the eigenvalues' sum and product.
    (sphere,) = scene["entities"][0]["spheres"]
    squares = [(sphere["size"][axis] / 2 / 2.4477) ** 2 for axis in "xy"]
    determinant = covariance[0] * covariance[4] - covariance[1] ** 2
    assert math.isclose(sum(squares), covariance[0] + covariance[4], rel_tol=1e-6)
    assert math.isclose(squares[0] * squares[1], determinant, rel_tol=1e-6)
for _, transform in topics[("/tf", "foxglove.FrameTransform")]:
    assert math.isclose(sum(part**2 for part in transform["rotation"].values()), 1, rel_tol=1e-9)
print(f"{summary.statistics.message_count} messages of {len(frames)} frames, {len(fixed)} fixes")
