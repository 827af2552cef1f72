"""Common code of the adapters of other renderers: reading a scene translated by `neutral_scene.py`, and
writing the picture.

Mitsuba reads the scene, but need not be installed in the renderers' own Python environments: `MITSUBA_PYTHON`
names the interpreter that has it (`python3` by default). A translation is kept in the folder
`ETALON_TRANSLATIONS` (in the temporary folder by default), under the hash of the scene's files and of the
translating scripts.
"""
import hashlib
import json
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import scene_features


def scene(path):
    """The translation of a Mitsuba file; ends the program with the reason if it fails."""
    here = Path(__file__).parent
    translators = b"".join((here / name).read_bytes() for name in ("neutral_scene.py", "neutral_mesh.py"))
    known = hashlib.sha256(str(Path(path).resolve()).encode() + translators)
    for file in files(Path(path).resolve()):
        known.update(hashlib.sha256(file.read_bytes()).digest())
    name = known.hexdigest()[:24]
    kept = Path(os.environ.get("ETALON_TRANSLATIONS", Path(tempfile.gettempdir()) / "etalon-translations"))
    folder = kept / name
    if not (folder / "scene.json").exists():
        python = os.environ.get("MITSUBA_PYTHON", "python3")
        command = [python, str(Path(__file__).with_name("neutral_scene.py")), str(path), str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, env=clean())
        if done.returncode != 0:
            sys.exit((done.stderr.strip() or "the scene was not translated").splitlines()[-1])
    return json.loads((folder / "scene.json").read_text())


def files(path):
    """The scene and every file that it reads; the scene alone if one is missing, which its translation
    reports."""
    try:
        return scene_features.inputs(path)
    except StopIteration:
        return [path]


def clean():
    """The environment without the variables set by a virtual environment's interpreter."""
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONHOME", "PYTHONPATH", "__PYVENV_LAUNCHER__")}


def write_exr(path, pixels):
    """Writes an array of rows from the top, of RGB pixels, as an uncompressed OpenEXR file (channels B, G, R
    in f32).
    """
    height, width, _ = pixels.shape
    text = lambda value: value.encode() + b"\0"
    attribute = lambda name, kind, data: text(name) + text(kind) + struct.pack("<i", len(data)) + data
    channels = b"".join(text(name) + struct.pack("<iB3xii", 2, 0, 1, 1) for name in "BGR") + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2) + b"".join([
        attribute("channels", "chlist", channels), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    size = 8 + 12 * width
    first = len(header) + 8 * height
    offsets = b"".join(struct.pack("<q", first + size * row) for row in range(height))
    rows = [struct.pack("<ii", row, 12 * width) + pixels[row][:, ::-1].T.astype("<f4").tobytes() for row in range(height)]
    Path(path).write_bytes(header + offsets + b"".join(rows))
