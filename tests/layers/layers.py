"""Are the layers as drawn? Includes cross no layer that CMake does not declare; no module is dead in the program.

layers.py includes SOURCE      every #include of a module's files is of that module or of one it depends on
layers.py linked SOURCE MAP    every file of the modules is linked into the program (GNU ld's map file), every
                               header included by one that is; exceptions are `offered`
"""
import pathlib
import re
import sys

folders = ["core", "core/solver", "primitives", "arrangement", "envelope", "io"]

# What users of the library call and the program does not: trisectors, all roots of a system, arrangements of any
# curves. It is made of what computes cells, and of itself. What cells are computed with one day is struck off.
offered = {
    "arrangement/curves/curve_arcs.cpp",
    "arrangement/curves/curve_arcs.hpp",
    "arrangement/curves/curve_meetings.cpp",
    "arrangement/curves/curve_points.cpp",
    "arrangement/curves/curve_points.hpp",
    "arrangement/curves/exact_points.cpp",
    "arrangement/curves/exact_points.hpp",
    "arrangement/curves/monotone_graph.cpp",
    "arrangement/curves/monotone_graph.hpp",
    "arrangement/sweep/point_location.hpp",
    "core/curves/bernstein.cpp",
    "core/curves/bernstein.hpp",
    "core/solver/newton/quadratic_kernel.hpp",
    "core/solver/roots/search.hpp",
    "core/solver/roots/solver.hpp",
    "envelope/cell_changes.cpp",
    "envelope/cell_changes.hpp",
    "envelope/lift/curve_lift.cpp",
    "envelope/trisector/curve_components.cpp",
    "envelope/trisector/curve_components.hpp",
    "envelope/trisector/plane_lines.cpp",
    "envelope/trisector/plane_lines.hpp",
    "envelope/trisector/region_clipping.cpp",
    "envelope/trisector/region_clipping.hpp",
    "envelope/trisector/trisector_curves.cpp",
    "envelope/trisector/trisector_curves.hpp",
    "envelope/trisector/uncut_curves.cpp",
    "envelope/trisector/uncut_curves.hpp",
    "primitives/bases/feet.cpp",
    "primitives/bases/feet.hpp",
    "primitives/bases/solid_bases.cpp",
    "primitives/bases/solid_bases.hpp",
    "primitives/bisectors/trisector.cpp",
    "primitives/bisectors/trisector.hpp",
    "primitives/bisectors/vertex_roots.cpp",
    "primitives/bisectors/vertex_roots.hpp",
}


class Module:
    def __init__(self, source, folder):
        text = (source / folder / "CMakeLists.txt").read_text()
        self.name, body = re.search(r"vcell_module\((\w+)(.*?)\)", text, re.S).groups()
        depends = re.search(r"\bDEPENDS\s+([\w\s]+)", body)
        self.depends = depends.group(1).split() if depends else []
        self.folder = source / folder
        self.sources = [self.folder / s for s in re.findall(r"[\w/]+\.cpp", body)]


class Tree:
    def __init__(self, source):
        self.source = source
        self.modules = {m.name: m for m in (Module(source, f) for f in folders)}

    def owner(self, path):
        """The module in whose folder the file lies: the innermost one."""
        owners = [(len(m.folder.parts), m.name) for m in self.modules.values() if m.folder in path.parents]
        return max(owners)[1] if owners else None

    def files(self):
        """Pairs of a module's file and the module's name."""
        for folder in dict.fromkeys(f.split("/")[0] for f in folders):
            for path in sorted((self.source / folder).glob("**/*.[ch]pp")):
                yield path, self.owner(path)

    def reachable(self, name):
        """The module and all that it depends on, however indirectly."""
        seen, waiting = set(), [name]
        while waiting:
            n = waiting.pop()
            if n not in seen:
                seen.add(n)
                waiting += self.modules[n].depends
        return seen

    def includes(self, path):
        for target in re.findall(r'^#include "([^"]+\.hpp)"', path.read_text(), re.M):
            yield target, (path.parent / target).resolve()

    def short(self, path):
        return path.relative_to(self.source).as_posix()


def check_includes(tree):
    for path, name in tree.files():
        allowed = tree.reachable(name)
        for target, to in tree.includes(path):
            owner = tree.owner(to)
            if not to.exists() or owner not in allowed:
                yield (f"{tree.short(path)}: includes {target}, of {owner or 'no module'}; {name} depends on "
                       f"{', '.join(sorted(allowed - {name})) or 'nothing'}")


def check_linked(tree, map_file):
    objects = set(re.findall(r"libvcell_(\w+)\.a\((\w+\.cpp)\.o\)", map_file.read_text()))
    live = {s for m in tree.modules.values() for s in m.sources if (m.name, s.name) in objects}
    waiting = list(live) + list((tree.source / "apps").glob("*.cpp"))
    while waiting:
        for _, to in tree.includes(waiting.pop()):
            if to.exists() and to not in live:
                live.add(to)
                waiting.append(to)
    for path, name in tree.files():
        # A folder's header for users includes the others.
        if path.stem == path.parent.name and tree.modules[name].folder == path.parent:
            continue
        is_offered = tree.short(path) in offered
        if path in live and is_offered:
            yield f"{tree.short(path)}: cells are computed with it; strike it off"
        if path not in live and not is_offered:
            yield f"{tree.short(path)}: nothing that computes a cell uses it"
        if is_offered:
            for target, to in tree.includes(path):
                if to.exists() and to not in live and tree.short(to) not in offered:
                    yield f"{tree.short(path)}: includes {target}, which computes no cell and is not offered"
    for name in sorted(offered):
        if not (tree.source / name).exists():
            yield f"{name}: is gone; strike it off"


def main():
    what, source = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    tree = Tree(source)
    faults = list(check_includes(tree) if what == "includes" else check_linked(tree, pathlib.Path(sys.argv[3])))
    print(*faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
