"""Checks that an exported model says what its checkpoint says: largest difference over held-out maps, and on an empty one.

    python -m gonio_training.parity --gonio ../target/release/gonio --checkpoint out/set.pt --model ../models/gonio-lobe-small.onnx
"""

import argparse
import time
from pathlib import Path

import numpy as np
import onnxruntime
import torch

from .data import SLOTS, Batch, sets, stream
from .export import answers, load

SEED = 3_000_000
ALLOWED = 1e-5


def run(model: Path, maps: np.ndarray, lights: np.ndarray | None = None, threads: int = 1) -> np.ndarray:
    """Materials [N, 7] of what the model's first input takes: sets of bins [N, S, 7], or dense maps [N, 3, 60, 120]; with the
    lights [N, 9] where it has a second."""
    return timed(model, maps, lights, threads)[0]


def timed(model: Path, maps: np.ndarray, lights: np.ndarray | None = None, threads: int = 1) -> tuple[np.ndarray, float]:
    """The same, and the milliseconds that a map took."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    session = onnxruntime.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
    inputs = dict(zip([i.name for i in session.get_inputs()], (maps, lights), strict=False))

    def batch(i: int) -> dict[str, np.ndarray]:
        return {name: values[i : i + 64] for name, values in inputs.items()}

    session.run(["mu"], batch(0))
    started = time.perf_counter()
    parts = [session.run(["mu"], batch(i))[0] for i in range(0, len(maps), 64)]
    return np.concatenate(parts), 1e3 * (time.perf_counter() - started) / len(maps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--checkpoint", type=Path, default=Path("out/set.pt"))
    parser.add_argument("--model", type=Path, default=Path("../models/gonio-lobe-small.onnx"))
    parser.add_argument("--count", type=int, default=2048)
    args = parser.parse_args()

    network, state = load(args.checkpoint)
    batch: Batch = next(stream(args.gonio, state["prior"], SEED, args.count, args.count))
    difference = np.abs(run(args.model, sets(batch), batch.light.numpy()) - answers(network, batch).numpy()).max()
    empty = run(args.model, np.zeros((1, SLOTS, 7), np.float32), np.array([[0, 0, 1, 1, 1, 1, 0, 0, 0]], np.float32))
    sound = bool(np.isfinite(empty).all() and (empty >= 0).all() and (empty <= 1).all())
    print(f"largest difference of {args.count} maps {difference:.1e}, {ALLOWED:.0e} allowed; empty map sound: {sound}")
    raise SystemExit(0 if difference <= ALLOWED and sound else 1)


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
