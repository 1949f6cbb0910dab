"""How many functions know what kind of base they work over? One chart and one form should know it for all of them.

kinds.py SOURCE           fails unless the functions counted in the folders below are exactly as many as `known` says:
                          the number can only shrink, and what was gained is written down
kinds.py SOURCE --list    prints them by file

A function counts once, its lambdas with it, if it names the kind of base: asks for it, switches on it, branches at
compile time on the base's type, takes or passes on a flag that says it, or looks into the variant of base and scene.
So does each of several functions of one name of which one takes the plane's problem and another that of the curved
bases: the compiler tests there. What tests for the kind of an *object* is mathematics of bisectors and does not count.

io/check does not count. It is the judge of what the engine wrote, shares nothing with the engine on purpose, and so
must tell the bases apart by itself.
"""
import pathlib
import re
import sys

known = 24
folders = ["envelope", "io", "apps"]
apart = ["io/check"]

naming = re.compile(r"""
    \b(is|over|on)_(plane|sphere|cylinder|radial|curved)(_base)?_?\b(?!\s*=\s*false;)
  | \bRadialChart\b | \bBaseShape\b
  | \bKind::(Plane|Sphere|Cylinder)\b
  | \b(holds_alternative|get_if|get)<\w+>\(&?[\w.\->]*\bbase_?\)
  | \bvisit\([^;]*\bbase_?\)
  | \bis_same_v<[^;]*(BaseProblem|Diagram)\b
  | \bradial\.empty\(\)
""", re.X)
plane_only = re.compile(r"\bPlane(BaseProblem|Diagram)\b")
curved_only = re.compile(r"\bRadial(BaseProblem|Diagram)\b")


def blanked(text):
    """The text without comments, literals and directives; every offset and line stays what it was."""
    pattern = r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#[^\n]*'
    return re.sub(pattern, lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.S | re.M)


def end_of_block(text, at):
    """The place behind the brace that closes the one at `at`."""
    depth = 0
    for m in re.compile(r"[{}]").finditer(text, at):
        depth += 1 if m[0] == "{" else -1
        if depth == 0:
            return m.end()
    return len(text)


def functions(text, at=0, end=None):
    """Head and body of every function of a namespace's or class's block, in order, with its offset."""
    end = len(text) if end is None else end
    begin = at
    while at < end:
        c = text[at]
        if c in ";}":
            begin = at + 1
        elif c == "(":  # brackets within an argument list open no block
            depth = 0
            while at < end:
                depth += {"(": 1, ")": -1}.get(text[at], 0)
                if depth == 0:
                    break
                at += 1
        elif c == "{":
            head, close = text[begin:at], end_of_block(text, at)
            if re.search(r"\bnamespace\b|\bextern\b", head) or re.search(r"\b(class|struct|union)\b[^()]*$",
                                                                       re.sub(r"template\s*<[^{]*?>(?=\s)", "", head)):
                yield from functions(text, at + 1, close - 1)
                begin = close
            elif re.search(r"\benum\b", head):
                begin = close
            elif "(" in head and not re.search(r"[^=!<>]=\s*$", head) and not (
                    re.search(r"\)[^()]*[^:]:[^:]", head) and re.search(r"[\w>]\s*$", head)):
                yield begin, head, text[at:close]
                begin = close
            # Otherwise it is an initialiser, of a variable or of a member: the head goes on.
            at = close - 1
        at += 1


def name_of(head):
    found = re.search(r"([\w:~]+|operator\W+)\s*\(", head)
    return found[1] if found else head.strip()


def arguments_of(head):
    return head[head.find(name_of(head)):]


def counted(source):
    """File, line and name of every function that counts."""
    all_of, named = [], set()
    for folder in folders:
        for path in sorted((source / folder).glob("**/*.[ch]pp")):
            short = path.relative_to(source).as_posix()
            if any(short.startswith(a + "/") for a in apart):
                continue
            text = blanked(path.read_text())
            for at, head, body in functions(text):
                first = len(head) - len(head.lstrip())
                place = (short, text.count("\n", 0, at + first) + 1, name_of(head))
                all_of.append((place, head))
                if naming.search(head + body):
                    named.add(place)
    by_name = {}
    for place, head in all_of:
        by_name.setdefault(place[2], []).append((place, head))
    for same in by_name.values():
        plane = [p for p, head in same if plane_only.search(arguments_of(head))]
        curved = [p for p, head in same if curved_only.search(arguments_of(head))]
        if plane and curved:
            named.update(plane + curved)
    return sorted(named)


def main():
    found = counted(pathlib.Path(sys.argv[1]).resolve())
    if "--list" in sys.argv[2:]:
        for path in dict.fromkeys(p for p, _, _ in found):
            here = [f"  {line}: {name}" for p, line, name in found if p == path]
            print(f"{path}: {len(here)}", *here, sep="\n")
        print(f"{len(found)} functions")
        return
    if len(found) > known:
        print(f"{len(found)} functions name the kind of base, {known} did: let the chart or the form know it")
    elif len(found) < known:
        print(f"only {len(found)} functions name the kind of base: write that in {pathlib.Path(__file__).name}")
    sys.exit(len(found) != known)


if __name__ == "__main__":
    main()
