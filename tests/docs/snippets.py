"""Runs the shell snippets of a page as a reader does: snippets.py PAGE PROGRAM FOLDER SOURCE.

Blocks marked sh run one after the other in FOLDER, where examples and tests are SOURCE's and vcell is PROGRAM. The
lines of a text block that follows one are what it prints: words the same, numbers within 1e-6 of each other.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys


def blocks(page):
    return re.findall(r"^```(\w+)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)


def same_word(a, b):
    try:
        x, y = float(a), float(b)
    except ValueError:
        return a == b
    return abs(x - y) <= 1e-6 * max(abs(x), abs(y)) or max(abs(x), abs(y)) < 1e-5


def same_text(printed, told):
    lines, expected = printed.strip().splitlines(), told.strip().splitlines()
    return len(lines) == len(expected) and all(
        len(a.split()) == len(b.split()) and all(map(same_word, a.split(), b.split())) for a, b in zip(lines, expected))


def environment_in(folder, program, source):
    """A folder that looks like the source to commands, with the program on the path."""
    (folder / "bin").mkdir(parents=True)
    (folder / "bin" / "vcell").symlink_to(program)
    for name in ("examples", "tests"):
        (folder / name).symlink_to(source / name)
    return dict(os.environ, PATH=f"{folder / 'bin'}:{os.environ['PATH']}", LC_ALL="C")


def main():
    page, program, folder, source = (pathlib.Path(a).resolve() for a in sys.argv[1:5])
    shutil.rmtree(folder, ignore_errors=True)
    environment = environment_in(folder, program, source)
    faults, ran, compared, printed = [], 0, 0, None
    for kind, text in blocks(page):
        if kind == "sh":
            run = subprocess.run(["sh", "-eu", "-c", text], cwd=folder, env=environment, text=True, capture_output=True,
                                 check=False)
            printed = run.stdout
            ran += 1
            if run.returncode != 0:
                faults.append(f"exit status {run.returncode}:\n{text}{run.stderr}")
        elif kind == "text" and printed is not None:
            compared += 1
            if not same_text(printed, text):
                faults.append(f"the page says\n{text}and the program\n{printed}")
            printed = None
    print(f"{page.name}: {ran} snippets ran, {compared} outputs compared", *faults, sep="\n")
    sys.exit(bool(faults) or ran == 0 or compared == 0)


if __name__ == "__main__":
    main()
