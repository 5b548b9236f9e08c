"""Maps of predicted materials from gonio's own renderer: the one that made the maps they were predicted from."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np


def render(gonio: str, options: list[str], **inputs: np.ndarray) -> np.ndarray:
    """Maps [N, 3, 60, 120] float32, clipped at 1, that `gonio synth spheres` draws of inputs [N, ...]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [gonio, "synth", "spheres", *options, "--count", str(len(inputs["materials"]))]
        for name, values in inputs.items():
            path = Path(folder) / f"{name}.npy"
            np.save(path, np.ascontiguousarray(values, np.float32))
            command += [f"--{name}", str(path)]
        out = Path(folder) / "out"
        subprocess.run([*command, "--out", str(out)], check=True, stdout=subprocess.DEVNULL)
        return np.minimum(np.load(out / "maps.npy"), 1.0)


def spheres(gonio: str, camera: str, materials: np.ndarray, lights: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Spheres of materials [N, 7] under lights [N, 3] as views [N, 3] see them."""
    options = ["--kind", "sphere", "--camera", camera]
    return render(gonio, options, materials=materials, lights=lights, views=views)


def lobes(gonio: str, materials: np.ndarray, lights: np.ndarray) -> np.ndarray:
    """What surfaces of materials [N, 7] send everywhere under lights [N, 3]; rows of the front half, [N, 3, 30, 120]."""
    return render(gonio, ["--kind", "lobe"], materials=materials, lights=lights)[:, :, :30]
