"""Has every type one definition? Two of one name in one namespace are one type to the linker, which takes the inline
functions of either for both: what they do to the other one's objects is anything. No compiler sees that.

definitions.py SOURCE     fails where files define types of one name in the namespaces of the libraries and programs
"""
import collections
import pathlib
import re
import sys

from kinds import blanked

folders = ["apps", "arrangement", "bench", "core", "envelope", "examples", "io", "mpi", "primitives", "python", "tests"]

# A namespace's head, a type's head (members that are types are named by their class), or a brace.
token = re.compile(r"\bnamespace\b\s*([\w:]*)\s*\{|\b(?:class|struct|union|enum(?: class)?) ([\w:]+)(?: final)?"
                   r"(?:\s*:(?!:)[^;{}()]*)?\s*(?:<[^;{}()]*>\s*)?\{|[{}]")


def types_of(text):
    """Qualified names of the types that a file defines where others could: in no unnamed namespace and no function."""
    scopes = []  # names; of an unnamed namespace "", of any other block None
    for m in token.finditer(text):
        if m[0] == "}":
            if scopes:
                scopes.pop()
        elif m[0] == "{":
            scopes.append(None)
        elif m[0].startswith("namespace"):
            scopes.append(m[1])
        else:
            if None not in scopes and "" not in scopes:
                yield "::".join([*scopes, m[2]])
            scopes.append(m[2])


def main():
    source = pathlib.Path(sys.argv[1]).resolve()
    files = collections.defaultdict(set)
    for folder in folders:
        for path in sorted((source / folder).glob("**/*.[ch]pp")):
            for name in types_of(blanked(path.read_text())):
                files[name].add(path.relative_to(source).as_posix())
    faults = [f"{name}: {', '.join(sorted(of))}" for name, of in sorted(files.items()) if len(of) > 1]
    print(f"{len(files)} types", *faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
