"""Pages in headless Chromium, by mouse and keyboard: page_test.py VCELL SCENES. Exit status 77 where there is no Chromium.

Where to click is computed from the mesh that `vcell compute -o cell.obj` writes, and what must be chosen then from the
cell file: neither knows of the page.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import browser


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def hits(eye, to, triangle):
    """Does the segment from the eye pass through the triangle before it ends?"""
    a, b, c = triangle
    along, u, v = minus(to, eye), minus(b, a), minus(c, a)
    p = cross(along, v)
    scale = dot(u, p)
    if scale == 0:
        return False
    from_a = minus(eye, a)
    q = cross(from_a, u)
    s, t, reach = dot(from_a, p) / scale, dot(along, q) / scale, dot(v, q) / scale
    return s >= 0 and t >= 0 and s + t <= 1 and 0 < reach < 0.999


def read_obj(path):
    """Triangles by face, and points all along the edges, however long their chords are."""
    points, faces, line_points, face = [], {}, [], None
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "v":
            points.append([float(x) for x in rest])
        elif word == "g":
            face = int(rest[0].split("_")[1]) if rest[0].startswith("face_") else None
        elif word == "f" and face is not None:
            faces.setdefault(face, []).append([points[int(c.split("//")[0]) - 1] for c in rest])
        elif word == "l":
            line = [points[int(c) - 1] for c in rest]
            line_points += [[(1 - s / 12) * x + s / 12 * y for x, y in zip(a, b)]
                            for a, b in zip(line, line[1:]) for s in range(13)]
    return faces, line_points


class Page:
    def __init__(self, chromium, page, fragment=""):
        self.browser = chromium
        self.address = page.resolve().as_uri()
        chromium.open(self.address + fragment)

    def ask(self, expression):
        return self.browser.evaluate(expression)

    def places(self, points):
        return self.ask(f"{json.dumps(points)}.map(p => vcell.place(p))")

    def chosen(self):
        return self.ask("document.querySelector('#chosen .what')?.textContent ?? null")

    def chosen_in_diagram(self):
        return self.ask("[...document.querySelectorAll('#diagram [data-face].chosen')].map(e => Number(e.dataset.face))")

    def set(self, name, value):
        assignment = f"checked = {json.dumps(value)}" if isinstance(value, bool) else f"value = {json.dumps(value)}"
        self.ask(f"(c => {{ c.{assignment}; c.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
                 f"(document.querySelector('#controls [name={name}]'))")
        self.browser.settle()

    def check_alone(self):
        assert self.browser.complaints() == [], self.browser.complaints()
        asked = {address.split("#")[0] for address in self.browser.requests()}
        assert asked == {self.address}, asked


def title(cell, site):
    if not isinstance(site, int):
        return str(site)
    name = cell["scene"]["objects"][site].get("name")
    return f"object {site} ({name})" if name else f"object {site}"


def visible_places(page, faces, line_points):
    """Of each face that can be seen a place on the screen, farther than 12 pixels from all edges."""
    eye = page.ask("(v => v.orbit.camera.position.toArray().map((x, k) => v.center[k] + v.size * x))(vcell.view)")
    edges = page.places(line_points)
    everything = [t for triangles in faces.values() for t in triangles]
    found = {}
    for face, triangles in faces.items():
        centers = [[sum(p[k] for p in t) / 3 for k in range(3)] for t in triangles]
        rated = []
        for center, place in zip(centers, page.places(centers)):
            rated.append((min((place[0] - x) ** 2 + (place[1] - y) ** 2 for x, y in edges[::3]), center, place))
        for square, center, place in sorted(rated, reverse=True)[:4]:
            if square > 144 and not any(hits(eye, center, t) for t in everything):
                found[face] = place
                break
    return found


def test_click(chromium, vcell, folder, scene):
    """A click on a face chooses it, shows its neighbour and marks it in the diagram; and the other way round."""
    files = [folder / f"cell.{ending}" for ending in ["html", "obj", "json"]]
    subprocess.run([vcell, "compute", scene, "--chord", "1%", *[x for f in files for x in ("-o", f)]], check=True)
    cell = json.loads(files[2].read_text())
    faces, line_points = read_obj(files[1])
    page = Page(chromium, files[0])
    assert page.chosen() is None
    places = visible_places(page, faces, line_points)
    assert len(places) >= 2, places
    for face, (x, y) in places.items():
        chromium.click(x, y)
        expected = title(cell, cell["faces"][face]["site"])
        assert page.chosen() == expected, (face, page.chosen(), expected)
        assert page.chosen_in_diagram() == [face]
        assert page.ask("document.querySelector('#table tr.chosen button').textContent") == expected
        assert page.ask("[...vcell.view.painted.keys()]") == [f"0:{face}"]
        assert page.ask("location.hash").endswith(f"face%3A{face}")

    # The other way round, on a place inside its path that nothing else covers.
    for face in range(len(cell["faces"])):
        place = page.ask(f"""(path => {{
          path.scrollIntoView({{block: 'center'}});
          const frame = path.getBoundingClientRect();
          for (let i = 1; i < 40; ++i) for (let k = 1; k < 40; ++k) {{
            const x = frame.left + frame.width * i / 40, y = frame.top + frame.height * k / 40;
            if (document.elementFromPoint(x, y) === path) return [x, y];
          }}
        }})(document.querySelector('#diagram [data-face="{face}"]'))""")
        if not place:  # too small a face, below its vertices
            assert cell["faces"][face]["area"] < 1e-3 * sum(f["area"] for f in cell["faces"]), face
            continue
        chromium.click(*place)
        assert page.chosen() == title(cell, cell["faces"][face]["site"])
        assert page.ask(f"vcell.view.painted.get('0:{face}')") == 0.7

    # A vertex tells its clearance and shows the ball of it. Each of the first few that no face hides does.
    seen = 0
    for number, place in enumerate(page.places([v["point"] for v in cell["vertices"]])):
        if seen == 3:
            break
        chromium.move_to(*place)
        if page.ask("document.getElementById('tip').hidden"):
            continue
        text = page.ask("document.getElementById('tip').textContent")
        if f"vertex {number} " not in text:
            continue  # a face hides it
        seen += 1
        clearance = float(text.split()[1])
        assert abs(clearance - cell["vertices"][number]["radius"]) < 1e-6 * clearance
        radius = page.ask("vcell.view.ball.visible && vcell.view.ball.scale.x * vcell.view.size")
        assert abs(radius - clearance) < 1e-6 * clearance
        assert page.ask(f"document.querySelector('#diagram [data-vertex=\"{number}\"]').classList.contains('hovered')")
    assert seen > 0

    # Escape chooses nothing.
    chromium.press("Escape")
    assert page.chosen() is None and page.chosen_in_diagram() == []
    page.check_alone()
    return len(places), seen


def test_controls(chromium, page_file):
    """A fragment chooses; keys, drags and the wheel turn; what is cut off or left out cannot be pointed at."""
    page = Page(chromium, page_file, "#face:1")
    assert page.chosen_in_diagram() == [1]
    chromium.press("Escape")
    assert page.chosen() is None
    middle = page.ask("(f => [f.left + f.width / 2, f.top + f.height / 2])(document.getElementById('canvas').getBoundingClientRect())")
    before = page.ask("vcell.view.orbit.azimuth")
    page.ask("document.getElementById('canvas').focus()")
    chromium.press("ArrowLeft")
    assert page.ask("vcell.view.orbit.azimuth") > before
    chromium.press("Home")
    assert page.ask("vcell.view.orbit.azimuth") == before
    # A drag turns, and chooses nothing.
    chromium.mouse("mousePressed", *middle, button="left", clickCount=1)
    chromium.mouse("mouseMoved", middle[0] + 60, middle[1], button="left", buttons=1)
    chromium.mouse("mouseReleased", middle[0] + 60, middle[1], button="left", clickCount=1)
    chromium.settle()
    assert page.ask("vcell.view.orbit.azimuth") < before and page.chosen() is None
    chromium.mouse("mouseWheel", *middle, deltaX=0, deltaY=-300)
    chromium.settle()
    assert page.ask("vcell.view.orbit.zoom") > 1.5
    page.ask("document.querySelector('[name=reset]').click()")

    grid = """(() => { const found = [];
      for (let x = 0.05; x < 1; x += 0.05) for (let y = 0.05; y < 1; y += 0.05) {
        const c = vcell.view.canvas, pick = vcell.view.pickFace(x * c.clientWidth, y * c.clientHeight);
        found.push(pick ? pick.pick.index : -1);
      }
      return found; })()"""
    whole = page.ask(grid)
    page.set("clip_axis", "x")
    kept = page.ask(grid)
    page.set("clip_flip", True)
    rest = page.ask(grid)
    covered = [sum(f >= 0 for f in found) for found in (whole, kept, rest)]
    assert 0 < covered[1] < covered[0] and 0 < covered[2] < covered[0], covered
    page.set("clip_axis", "")
    page.set("faces", False)
    assert page.ask(grid) != whole and not any(page.ask("vcell.view.layers.faces.map(f => f.visible)"))
    page.check_alone()


def test_vessels(chromium, vcell, folder, scenes):
    """Scenes with vessels are drawn, their walls with them."""
    for scene in ["vessel", "silo", "hopper"]:
        subprocess.run([vcell, "compute", scenes / f"{scene}.json", "-o", folder / f"{scene}.html"], check=True)
        page = Page(chromium, folder / f"{scene}.html")
        assert page.ask("document.getElementById('failure').hidden"), page.ask("document.getElementById('failure').textContent")
        objects = json.loads((scenes / f"{scene}.json").read_text())
        count = len(objects["objects"]) - ("base_object" in objects)
        shown = page.ask("(l => (l.neighbours || []).length + (l.others || []).length)(vcell.view.layers)")
        assert shown == count, (scene, shown, count)
        page.check_alone()


def test_names(chromium, vcell, folder):
    """Names with markup in them are text on the page."""
    name = "</script></title><img src=x onerror='document.title=0'><!-- \"é\u2028&amp; ]]>"
    scene = {"vcell": 1, "base": {"sphere": {"center": [0, 0, 0], "radius": 1}, "name": name},
             "objects": [{"sphere": {"center": [3, 0, 0], "radius": 1}, "name": name},
                         {"sphere": {"center": [0, -3, 0], "radius": 0.5}}],
             "box": {"min": [-4, -4, -4], "max": [4, 4, 4]}}
    (folder / "names.json").write_text(json.dumps(scene))
    subprocess.run([vcell, "compute", folder / "names.json", "-o", folder / "names.html"], check=True)
    page = Page(chromium, folder / "names.html", "#site:0")
    assert page.chosen() == f"object 0 ({name})", page.chosen()
    assert page.ask("document.querySelector('h1').textContent") == f"Voronoi cell of a ball, {name}"
    assert page.ask("document.images.length") == 0 and page.ask("document.title").startswith("Voronoi cell")
    page.check_alone()


def test_diagram(chromium, vcell, folder):
    """Cells are chosen in the table and by a fragment, and move apart."""
    balls = [f"{1 + 2 * (i & 1)} {1 + (i & 2)} {1 + (i & 4) / 2} {0.2 + 0.05 * i} ball{i}" for i in range(8)]
    (folder / "balls.xyzr").write_text("\n".join(balls) + "\n")
    subprocess.run([vcell, "diagram", folder / "balls.xyzr", "-o", folder / "all.html"], check=True, stdout=subprocess.DEVNULL)
    page = Page(chromium, folder / "all.html", "#cell:5")
    assert page.chosen() == "object 5 (ball5)", page.chosen()
    assert len(page.ask("[...document.querySelectorAll('#table button')].map(b => b.textContent)")) == 8
    page.ask("document.querySelectorAll('#table button')[3].click()")
    assert page.chosen() == "object 3 (ball3)" and page.ask("location.hash").endswith("cell%3A3")
    neighbours = page.ask("document.getElementById('chosen').textContent")
    assert all(f"object {i} (ball{i})" in neighbours for i in (1, 2, 7)), neighbours
    distance = "vcell.view.cells[0].group.position.distanceTo(vcell.view.cells[7].group.position)"
    together = page.ask(distance)
    page.set("explode", "1")
    assert abs(page.ask(distance) - 2 * together) < 1e-6 * together
    page.set("alone", True)
    shown = page.ask("vcell.view.cells.map(c => c.group.visible)")
    assert shown[3] and not all(shown), shown
    # What is hidden cannot be pointed at.
    assert page.ask("""(() => { const c = vcell.view.canvas, cells = new Set();
      for (let x = 0.02; x < 1; x += 0.02) for (let y = 0.02; y < 1; y += 0.02) {
        const pick = vcell.view.pick(x * c.clientWidth, y * c.clientHeight);
        if (pick) cells.add(pick.cell);
      }
      return [...cells].every(i => vcell.view.cells[i].group.visible) && cells.size > 0; })()""")
    page.check_alone()


def main():
    vcell, scenes = sys.argv[1], pathlib.Path(sys.argv[2])
    path = browser.program()
    if path is None:
        print("skipped: no Chromium (Debian: chromium-headless-shell)")
        return 77
    with tempfile.TemporaryDirectory() as name, browser.Browser(path, 1000, 640, smooth=False) as chromium:
        folder = pathlib.Path(name)
        for scene in ["table3_04", "figure10", "figure8"]:
            faces, vertices = test_click(chromium, vcell, folder, scenes / f"{scene}.json")
            print(f"{scene}: {faces} faces clicked, {vertices} vertices pointed at")
        test_controls(chromium, folder / "cell.html")
        test_vessels(chromium, vcell, folder, scenes)
        test_names(chromium, vcell, folder)
        test_diagram(chromium, vcell, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
