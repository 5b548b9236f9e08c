"""Spheres of predicted materials from gonio's own renderer: the one that made the set."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np


def rerender(gonio: str, camera: str, materials: np.ndarray, lights: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Maps [N, 3, 60, 120] float32, clipped at 1, of materials [N, 7] under lights [N, 3] as views [N, 3] see them."""
    with tempfile.TemporaryDirectory() as folder:
        inputs = {"materials": materials, "lights": lights, "views": views}
        command = [gonio, "synth", "spheres", "--kind", "sphere", "--camera", camera, "--count", str(len(materials))]
        for name, values in inputs.items():
            path = Path(folder) / f"{name}.npy"
            np.save(path, np.ascontiguousarray(values, np.float32))
            command += [f"--{name}", str(path)]
        out = Path(folder) / "out"
        subprocess.run([*command, "--out", str(out)], check=True, stdout=subprocess.DEVNULL)
        return np.minimum(np.load(out / "maps.npy"), 1.0)
