"""The schemas of docs/schema against the program: schema.py SCHEMAS PROGRAM FOLDER SCENES... --diagrams SCENES...

What the program reads or writes is valid by the schema. What is damaged in one place is refused by both: every key
left out, misspelt or of another type, every list with an item too few. One of four damages is tried, which ones the
seed VCELL_TEST_SEED says; all of them where VCELL_TEST_ROUNDS is more than 1. Needs python3-jsonschema; exit status 77
without it.
"""
import copy
import itertools
import json
import os
import pathlib
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)


def load(path):
    return json.loads(pathlib.Path(path).read_text(encoding="utf-8"))


def validators(folder):
    schemas = {name: load(folder / f"{name}.schema.json") for name in ("scene", "cell", "diagram_scene", "diagram")}
    store = {schema["$id"]: schema for schema in schemas.values()}
    for schema in schemas.values():
        jsonschema.Draft202012Validator.check_schema(schema)
    return {
        name: jsonschema.Draft202012Validator(s, resolver=jsonschema.RefResolver.from_schema(s, store=store))
        for name, s in schemas.items()
    }


def damages(value, path=()):
    """(where, a function that damages a document there) for every place of a document; of lists the first item."""
    if isinstance(value, dict):
        for key in value:
            yield path + (key,), lambda parent, k=key: parent.pop(k)
            yield path + (key,), lambda parent, k=key: parent.update({k + "s": parent.pop(k)})
            yield path + (key,), lambda parent, k=key: parent.update({k: {"a": []}})
            yield from damages(value[key], path + (key,))
    elif isinstance(value, list) and value:
        if isinstance(value[0], (int, float)):
            yield path + (0,), lambda parent: parent.pop(0)
        yield path + (0,), lambda parent: parent.__setitem__(0, {"a": []})
        yield from damages(value[0], path + (0,))


def damaged(document, path, damage):
    changed = parent = copy.copy(document)
    for step in path[:-1]:
        parent[step] = copy.copy(parent[step])
        parent = parent[step]
    damage(parent)
    return changed


def shortened(value):
    """Of long lists the first item, which is damaged: a schema says of each what it says of that one."""
    if isinstance(value, dict):
        return {key: shortened(part) for key, part in value.items()}
    if isinstance(value, list):
        return [shortened(part) for part in (value if len(value) <= 4 else value[:1])]
    return value


def agree(validator, document, reads, faults, what, below=()):
    """Schema and program refuse the same damages, of all that is below a place."""
    part, short = document, shortened(document)
    for step in below:
        part = part[step]
    if not validator.is_valid(short):
        faults.append(f"{what}: not valid with fewer items")
    refused = 0
    first, step = (0, 1) if int(os.environ.get("VCELL_TEST_ROUNDS", 1)) > 1 else (int(os.environ.get("VCELL_TEST_SEED", 0)) % 4, 4)
    for path, damage in itertools.islice(damages(part, below), first, None, step):
        by_schema = not validator.is_valid(damaged(short, path, damage))
        by_program = not reads(damaged(document, path, damage))
        refused += by_schema
        if by_schema != by_program:
            faults.append(f"{what}: {path}: " + ("the schema alone refuses it" if by_schema else "the program alone does"))
    return refused


def main():
    schemas, program, folder = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)
    valid = validators(schemas)
    faults = []

    def run(verb, path, *more):
        return subprocess.run([program, verb, str(path), *more], capture_output=True, text=True, check=False).returncode

    def reads(verb, *more):
        def read(document):
            path = folder / "damaged.json"
            path.write_text(json.dumps(document), encoding="utf-8")
            return run(verb, path, *more) != 2
        return read

    scenes = cells = closed = refused = 0
    split = sys.argv.index("--diagrams")
    for scene_path in sys.argv[4:split]:
        scene = load(scene_path)
        scenes += 1
        for error in valid["scene"].iter_errors(scene):
            faults.append(f"{scene_path}: {list(error.path)}: {error.message}")
        cell_path = folder / "cell.json"
        if run("compute", scene_path, "-o", str(cell_path), "--moments", "--clearances") != 0:
            faults.append(f"{scene_path}: no cell")
            continue
        cell = load(cell_path)
        cells += 1
        for error in valid["cell"].iter_errors(cell):
            faults.append(f"cell of {scene_path}: {list(error.path)}: {error.message}")
        if "closing" in cell and closed == 0:
            closed += 1
            refused += agree(valid["cell"], cell, reads("refine", "--vertex", "0", "--bits", "1"), faults, "closing", ("closing",))
        if cells > 1:
            continue
        refused += agree(valid["scene"], scene, reads("measure"), faults, "scene")
        refused += agree(valid["cell"], cell, reads("refine", "--vertex", "0", "--bits", "1"), faults, "cell")
    diagrams = files = 0
    for scene_path in sys.argv[split + 1:]:
        scene = load(scene_path)
        diagrams += 1
        for error in valid["diagram_scene"].iter_errors(scene):
            faults.append(f"{scene_path}: {list(error.path)}: {error.message}")
        if run("diagram", scene_path) != 0:
            faults.append(f"{scene_path}: no diagram")
        if diagrams == 1:
            refused += agree(valid["diagram_scene"], scene, reads("diagram"), faults, scene_path)
        file_path = folder / "diagram.json"
        if run("diagram", scene_path, "-o", str(file_path)) != 0:
            continue
        whole = load(file_path)
        files += 1
        for error in valid["diagram"].iter_errors(whole):
            faults.append(f"diagram of {scene_path}: {list(error.path)}: {error.message}")
        # Which images there may be is no matter of a schema. One cell is like the others, and one of its elements.
        below = ("cells",) if any(scene.get("periodic", ())) else ("diagram",)
        whole["cells"] = whole["cells"][:1]
        for key in ("vertices", "edges", "faces"):
            whole["cells"][0][key] = whole["cells"][0][key][-1:]
        refused += agree(valid["diagram"], whole, reads("check", "--effort", "0"), faults, "diagram's file", below)
    # What is a scene of one cell is one of a diagram, too.
    for scene_path in sys.argv[4:split]:
        for error in valid["diagram_scene"].iter_errors(load(scene_path)):
            faults.append(f"{scene_path} as a diagram's: {list(error.path)}: {error.message}")
    print(f"{scenes} scenes, {cells} cells, {diagrams} diagrams, {files} of them as files, {refused} damages refused", *faults, sep="\n")
    sys.exit(bool(faults) or scenes == 0 or cells == 0 or closed == 0 or diagrams == 0 or files == 0 or refused < 100)


if __name__ == "__main__":
    main()
