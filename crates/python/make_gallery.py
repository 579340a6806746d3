"""Draws the gallery of the book, one picture an example: ``python make_gallery.py [--folder FOLDER] [EXAMPLE...]``.

The description of each SVG file holds the data that are drawn, so that a test compares numbers and not the bytes of one version of
Matplotlib.
"""

from __future__ import annotations

import argparse
import json
import re
import runpy
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
EXAMPLES = sorted((HERE / "examples").glob("*.py"))
PICTURES = HERE.parent / "book" / "src" / "pictures"
#: Settings without which equal pictures differ in bytes, or are large: identifiers, and letters drawn as paths.
SETTINGS: Any = {"svg.hashsalt": "slipgrid", "svg.fonttype": "none", "font.sans-serif": ["DejaVu Sans"]}
DESCRIPTION = "{http://purl.org/dc/elements/1.1/}description"


def picture(folder: Path, example: str) -> Path:
    """Path of the picture of the example in ``folder``."""
    return folder / f"gallery-{example.replace('_', '-')}.svg"


def drawn(figure: Any) -> list[dict[str, Any]]:
    """Labels and data of the axes of a figure: ends of all data, points of lines, levels of contours, heights of images."""

    def numbers(values: Any) -> list[float]:
        return [float(f"{value:.5g}") for value in values]

    return [
        {
            "labels": [ax.get_title(), ax.get_xlabel(), ax.get_ylabel()],
            "data": numbers(ax.dataLim.extents),
            "lines": [numbers([*line.get_xdata(), *line.get_ydata()]) for line in ax.lines if len(line.get_xdata()) > 1],
            "levels": [numbers([*own.levels, own.zmin, own.zmax]) for own in ax.collections if hasattr(own, "levels")],
            "images": [numbers([image.get_array().min(), image.get_array().max()]) for image in ax.images],
        }
        for ax in figure.axes
    ]


def described(path: Path) -> list[dict[str, Any]]:
    """Data in the description of the picture at ``path``."""
    found: list[dict[str, Any]] = json.loads(next(xml.parse(path).iter(DESCRIPTION)).text or "")
    return found


def brief(svg: str) -> str:
    """The drawing with rounded coordinates, without indents, names of groups, and styles of ticks that repeat those of their shape:
    it is half as large."""

    def rounded(kinds: str, decimals: int, text: str) -> str:
        def number(found: re.Match[str]) -> str:
            return f"{float(found[0]):.{decimals}f}".rstrip("0").rstrip(".")

        return re.sub(f' (?:{kinds})="[^"]*"', lambda found: re.sub(r"-?\d+\.\d+", number, found[0]), text)

    svg = rounded("transform", 2, rounded("d|x|y", 1, svg))
    svg = re.sub(r'<g id="[^"]*"', "<g", svg).replace("'DejaVu Sans', sans-serif", "sans-serif")
    svg = re.sub(r' transform="rotate\(-?0 [^"]*"', "", svg)
    svg = re.sub(r'(<use [^>]*?) style="stroke: #000000; stroke-width: 0.\d"', r"\1", svg)
    svg = "\n".join(line.strip() for line in svg.split("\n") if line.strip())
    return re.sub(r">\s*(?=</g>)", ">", svg) + "\n"


def draw(script: Path, folder: Path) -> None:
    """Runs the example and writes its picture into ``folder``."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with tempfile.TemporaryDirectory() as own:
        sys.argv = [str(script), own]
        runpy.run_path(str(script), run_name="__main__")
    figure, path = pyplot.gcf(), picture(folder, script.stem)
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(path, metadata={"Date": None, "Description": json.dumps(drawn(figure))})
    pyplot.close("all")
    path.write_text(brief(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draws the gallery of the book.")
    parser.add_argument("--folder", type=Path, default=PICTURES, help="folder of the pictures, that of the book by default")
    parser.add_argument("examples", nargs="*", help="names of examples, all by default")
    given = parser.parse_args()
    for script in EXAMPLES:
        if not given.examples or script.stem in given.examples:
            draw(script, given.folder)
