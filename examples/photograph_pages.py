#!/usr/bin/env python3
"""Photographs pages in headless Chromium: photograph_pages.py [--program build/release/apps/vcell] [-o docs/pictures]

Writes page_cell.png (a plane's cell, with a face chosen and a vertex pointed at), page_figure8.png, page_figure10.png
and page_diagram.png (all cells of crambin, moved apart).
"""
import pathlib
import subprocess
import sys
import tempfile

import make_pictures

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(SOURCE / "tests/page"))
import browser  # noqa: E402


def control(name, value):
    return (f"(c => {{ c.value = {value!r}; c.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
            f"(document.querySelector('#controls [name={name}]'))")


# What is computed, what is chosen, what else is done, and which vertex is pointed at.
VIEWS = {
    "page_cell": (["compute", "examples/scenes/table3_24.json"], "face:9", [], 12),
    "page_figure8": (["compute", "examples/scenes/figure8.json"], "face:2", [], 0),
    "page_figure10": (["compute", "examples/scenes/figure10.json"], "edge:2",
                      [control("clip_axis", "y"), control("clip_at", "0.62")], None),
    "page_diagram": (["diagram", "tests/data/1CRN.xyzr"], "cell:6", [control("explode", "0.5")], None),
}


def main():
    options = make_pictures.arguments(__doc__)
    with tempfile.TemporaryDirectory() as folder, browser.Browser(browser.program(), 1200, 720) as chromium:
        for name, ((verb, scene), fragment, actions, vertex) in VIEWS.items():
            if options.names and name not in options.names:
                continue
            page = pathlib.Path(folder) / f"{name}.html"
            subprocess.run([options.program, verb, SOURCE / scene, "-o", page], check=True, stdout=subprocess.DEVNULL)
            chromium.open(f"{page.as_uri()}#{fragment}")
            for action in actions:
                chromium.evaluate(action)
            if vertex is not None:
                chromium.move_to(*chromium.evaluate(f"vcell.place(vcell.cells[0].vertices[{vertex}].point)"))
            picture = options.output / f"{name}.png"
            chromium.screenshot(picture)
            print(picture)


if __name__ == "__main__":
    main()
