"""Prints the publication's table with ours beside it, from the files that `evaluate` wrote.

    python -m gonio_training.published.table results
"""

import argparse
import json
from pathlib import Path

from .architectures import ARCHITECTURES

DENSE = ("psnr", "nrmse", "dssim")
FORMATS = {"psnr": ".2f", "nrmse": ".4f", "dssim": ".5f", "kd": ".4f", "ks": ".4f", "r": ".4f"}


def line(cells: list[str]) -> str:
    """A row of a Markdown table."""
    return "| " + " | ".join(cells) + " |"


def shown(figures: dict, names: tuple[str, ...]) -> list[str]:
    """Figures as the table gives them."""
    return [format(figures[name], FORMATS[name]) for name in names]


def budget(told: dict) -> str:
    """How far a row was trained, and on how much it was measured."""
    end = "trained to the end" if told["to_the_end"] else "not trained to the end"
    return f"{told['maps_shown']:,} maps, {told['epochs']:g} epochs, {told['training_minutes']:g} min: {end}; {told['test_maps']:,} test maps"


def dense(results: dict[str, dict]) -> list[str]:
    """The publication's table: whole maps."""
    lines = [
        line(["architecture", "published PSNR", "NRMSE", "DSSIM", "here PSNR", "NRMSE", "DSSIM", "parameters", "budget"]),
        line(["---"] * 9),
    ]
    for name, architecture in ARCHITECTURES.items():
        published = [f"{p:{f}}" for p, f in zip(architecture.published or (), (".4f", ".4f", ".5f"), strict=False)] or ["-"] * 3
        here = ["-"] * 5
        if told := results.get(name):
            here = [*shown(told["filled_bins"]["all"], DENSE), f"{told['parameters']:,}", budget(told)]
        lines.append(line([architecture.title, *published, *here]))
    return lines


def by_bins(results: dict[str, dict]) -> list[str]:
    """The same by filled bins, with errors of the materials."""
    lines = [line(["architecture", "filled bins", "PSNR", "NRMSE", "DSSIM", "kd", "ks", "r"]), line(["---"] * 8)]
    for name, told in results.items():
        for bins, figures in told["filled_bins"].items():
            lines.append(line([ARCHITECTURES[name].title, bins, *shown(figures, tuple(FORMATS))]))
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="of the .json files of evaluate")
    args = parser.parse_args()
    found = {name: args.folder / f"{name}.json" for name in ARCHITECTURES}
    results = {name: json.loads(path.read_text()) for name, path in found.items() if path.exists()}
    print("\n".join([*dense(results), "", *by_bins(results)]))


if __name__ == "__main__":
    main()
