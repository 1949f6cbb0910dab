"""Is every file and every class small enough to be read at once? Beyond these limits there is a second concept in it.

sizes.py SOURCE           fails where a file has more than 600 lines, or a class more than 400
sizes.py SOURCE --list    prints the largest classes

A class has its lines from its head to its closing brace, and those of its members that its folder defines elsewhere;
a class in a class counts for itself, too.
"""
import collections
import pathlib
import re
import sys

from kinds import blanked, end_of_block, functions

most_of_file, most_of_class = 600, 400
folders = ["apps", "arrangement", "bench", "core", "envelope", "examples", "io", "mpi", "primitives", "python", "tests"]

class_head = re.compile(r"(?<!enum )\b(?:class|struct) ((?:\w+::)*\w+)(?: final)?(?:\s*:[^;{}()]*)?\s*\{")
member_name = re.compile(r"((?:\w+::)*\w+)(?:<[^<>()]*>)?::(?:~?\w+|operator\W+)\s*\(")


def sizes_of_classes(texts):
    """Lines by folder and name."""
    sizes, elsewhere = collections.Counter(), collections.Counter()
    for path, text in texts.items():
        folder = path.parent.as_posix()
        for m in class_head.finditer(text):
            lines = text.count("\n", m.start(), end_of_block(text, m.end() - 1)) + 1
            sizes[folder, m[1]] = max(lines, sizes[folder, m[1]])
        for _, head, body in functions(text):
            if member := member_name.search(head):
                elsewhere[folder, member[1]] += (head.lstrip() + body).count("\n") + 1
    return {key: lines + elsewhere[key] for key, lines in sizes.items()}


def main():
    source = pathlib.Path(sys.argv[1]).resolve()
    paths = [p.relative_to(source) for f in folders for p in sorted((source / f).glob("**/*.[ch]pp"))]
    texts = {p: (source / p).read_text() for p in paths}
    sizes = sizes_of_classes({p: blanked(t) for p, t in texts.items()})
    named = {f"{folder}: {name}": lines for (folder, name), lines in sizes.items()}
    if "--list" in sys.argv[2:]:
        for name, lines in sorted(named.items(), key=lambda item: -item[1])[:40]:
            print(f"{lines:5} {name}")
        return
    faults = [f"{p.as_posix()}: {n} lines" for p, t in texts.items() if (n := t.count("\n")) > most_of_file]
    faults += [f"{name}: {lines} lines" for name, lines in sorted(named.items()) if lines > most_of_class]
    print(*faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
