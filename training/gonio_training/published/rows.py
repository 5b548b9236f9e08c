"""Trains several rows of the table one after the other, in one process that reads the set once: for a GPU lent by the minute.

    python -m gonio_training.published.rows --data SET --out out --device cuda --bf16 --row wide-resnet-50=4 --row ours=1

Each is trained for so many minutes, or to its end; the same command with more minutes goes on.
"""

import argparse
from pathlib import Path

import torch

from .train import Parts, Run, arguments


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--row", action="append", required=True, metavar="ARCH=MINUTES")
    parser.add_argument("--out", type=Path, required=True, help="the folder of the checkpoints")
    ours, rest = parser.parse_known_args()

    parts = None
    for row in ours.row:
        arch, minutes = row.split("=", 1)
        options = [*rest, "--arch", arch, "--out", str(ours.out / f"{arch}.pt"), "--minutes", minutes]
        args = arguments().parse_args(options)
        torch.set_num_threads(args.threads)
        parts = parts or Parts.read(args)
        print(f"{arch}, {minutes} minutes", flush=True)
        Run(args, parts).go()


if __name__ == "__main__":
    main()
