"""Compares estimators on cities that no network was trained on: materials, and frames relit. Prints a Markdown table.

    python -m gonio_training.scenes --gonio ../target/release/gonio --work out/scenes --unlit lobe=../models/gonio-lobe-small.onnx

Cities of these seeds are made by `gonio synth city` (default size: 50,000 triangles, 60 frames) under its default sun, cast
once, and inferred from by each estimator. What is printed is the mean over the cities.
"""

import argparse
import json
import math
import subprocess
from pathlib import Path

SEEDS = (101, 102, 103)
# Degrees.
WRONG = 3
# The city's default light: 228 degrees from +x towards +y, 47 degrees high; the sky that `gonio synth city` names.
LIGHT = {"mode": "known", "sun": [-0.45634598, -0.50682354, 0.73135370], "sky": [0.16, 0.19, 0.24]}


def turned(degrees: float) -> dict:
    """The light with its sun turned about the zenith, so that both azimuth and angle are wrong by so much."""
    x, y, z = LIGHT["sun"]
    # A turn about the zenith moves the sun by less than its angle: its height shortens the way.
    angle = 2 * math.asin(math.sin(math.radians(degrees) / 2) / math.hypot(x, y))
    c, s = math.cos(angle), math.sin(angle)
    return LIGHT | {"sun": [c * x - s * y, s * x + c * y, z]}


def pipeline(scene: Path, work: Path, infer: dict, light: dict) -> str:
    """A pipeline file."""
    sections = {
        "scene": {
            "mesh": str(scene / "mesh.ply"),
            "images": str(scene / "images"),
        },
        "infer": infer,
        "light": light,
        "export": {"formats": []},
        "run": {"work": str(work), "memory": "2GiB"},
    }
    text = "".join(
        f"[{name}]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
        for name, keys in sections.items()
    )
    poses = f'poses = {{ format = "colmap", path = {json.dumps(str(scene / "sparse/0"))} }}\n'
    return text.replace("[scene]\n", "[scene]\n" + poses)


def judge(gonio: str, scene: Path, folder: Path, infer: dict, light: dict) -> list[dict]:
    """Runs one estimator on one city, and judges it in the city's own light."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "p.toml"
    # One work folder a city: what is cast stays, and only what the estimator touches is done again.
    file.write_text(pipeline(scene, folder / "work", infer, light))
    subprocess.run([gonio, "run", str(file)], check=True, capture_output=True)
    file.write_text(pipeline(scene, folder / "work", infer, LIGHT))
    truth = scene / "truth/materials.npy"
    told = subprocess.run(
        [gonio, "eval", "scene", str(file), "--truth", str(truth), "--json"], check=True, capture_output=True, text=True
    )
    return json.loads(told.stdout)


def row(name: str, judged: list[dict]) -> str:
    """The mean over the cities."""

    def mean(values: list[float]) -> float:
        return sum(values) / len(judged)

    errors = " | ".join(f"{mean([j[key] for j in judged]):.4f}" for key in ("kd", "ks", "r"))
    same = mean([j["same_light"] for j in judged])
    suns = [mean([j["suns"][i] for j in judged]) for i in range(len(judged[0]["suns"]))]
    return f"| {name} | {errors} | {same:.2f} | " + " | ".join(f"{sun:.2f}" for sun in suns) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--work", type=Path, default=Path("out/scenes"))
    kinds = {
        "unlit": ("network", "a network that is not told the light"),
        "lit": ("network", "a network that is"),
        "fit": ("network+fit", "a network that the fit starts from"),
    }
    for kind, (_, what) in kinds.items():
        parser.add_argument(f"--{kind}", action="append", default=[], metavar="NAME=FILE", help=f"{what}, .onnx")
    args = parser.parse_args()

    estimators, wrong = {"fit": ({"estimator": "fit"}, LIGHT)}, {"fit": {"estimator": "fit"}}
    for kind, (estimator, _) in kinds.items():
        for name, file in (named.split("=", 1) for named in getattr(args, kind)):
            infer = {"estimator": estimator, "model": str(Path(file).resolve())}
            # A network that is not told the light does not mind that the run knows it.
            estimators[name] = (infer, LIGHT)
            wrong |= {} if kind == "unlit" else {name: infer}
    estimators |= {f"{name}, sun {WRONG} degrees wrong": (infer, turned(WRONG)) for name, infer in wrong.items()}

    scenes = []
    for seed in SEEDS:
        scene = args.work / f"city-{seed}"
        subprocess.run([args.gonio, "synth", "city", "--out", str(scene), "--seed", str(seed)], check=True, capture_output=True)
        scenes.append(scene.resolve())
    print("| estimator | kd | ks | r | same sun | sun 20/60 | 35/150 | 55/290 | 75/0 |\n|---|---|---|---|---|---|---|---|---|")
    for name, (infer, light) in estimators.items():
        judged = [judge(args.gonio, scene, args.work.resolve() / scene.name / "run", infer, light) for scene in scenes]
        print(row(name, [city[0] for city in judged]), flush=True)
    # The trivial estimates are judged beside each, and are the same each time.
    for trivial in zip(*(city[1:] for city in judged), strict=False):
        print(row(trivial[0]["what"], trivial))


if __name__ == "__main__":
    main()
