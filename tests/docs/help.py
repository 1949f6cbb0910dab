"""Runs the examples that --help of the program and of its commands prints, as printed: help.py PROGRAM FOLDER SOURCE.

They run one after the other in FOLDER, where examples and tests are SOURCE's and vcell is PROGRAM, and have nothing to
complain about.
"""
import pathlib
import re
import shutil
import subprocess
import sys

from snippets import environment_in


def main():
    program, folder, source = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    environment = environment_in(folder, program, source)

    def run(command):
        return subprocess.run(["sh", "-eu", "-c", command], cwd=folder, env=environment, text=True, capture_output=True,
                              check=False)

    faults, ran = [], 0
    verbs = re.findall(r"^  ([a-z]+) {2,}", run("vcell --help").stdout.split("Subcommands:")[1].split("\n\n")[0], re.M)
    for command in ["vcell", *(f"vcell {verb}" for verb in verbs)]:
        text = run(f"{command} --help").stdout
        examples = re.findall(r"^  (.*\bvcell .*)$", text.partition("Examples")[2].partition("\n\n")[0], re.M)
        if not examples:
            faults.append(f"{command}: no examples")
        for example in examples:
            ran += 1
            result = run(example)
            if (result.returncode != 0 or result.stderr) and "built without three.js" not in result.stderr:
                faults.append(f"{example}\nexit status {result.returncode}: {result.stderr}")
    print(f"{len(verbs)} commands, {ran} examples ran", *faults, sep="\n")
    sys.exit(bool(faults) or len(verbs) < 7)


if __name__ == "__main__":
    main()
