"""Does another program find the solids that vcell writes closed, valid as they stand, and of our volume?

compare_step.py VCELL JUDGE [--complete | --diagram] [SCENE ...]   one line a scene (default: all of examples/scenes)

VCELL is the program, JUDGE one that is called with FILE.step --expect-volume V and prints a JSON object: `ok`, a list of
`problems`, and `as_written`, the shape without any repair, with `valid`, `shell_closed`, `volume`, the `count` of solids and
faces and the largest `tolerance`. V is the volume that `vcell measure` states. With --complete cells are complete, with
--diagram those of all objects are in one file, and V is the sum that `vcell diagram` states.
Ends with 1 if the judge objects to a scene.
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile


def judged(vcell, judge, options, scene, step):
    verb, *options = ["diagram"] if "--diagram" in options else ["compute", *options]
    computed = subprocess.run([vcell, verb, *options, scene, "-o", step], capture_output=True, text=True)
    if computed.returncode != 0:
        return None, computed.stderr.strip()
    table = computed.stdout if verb == "diagram" else subprocess.run(
        [vcell, "measure", *options, scene], capture_output=True, text=True, check=True).stdout
    volume = next(csv.DictReader(table.splitlines(), delimiter="\t"))["volume"]
    said = subprocess.run([judge, step, "--expect-volume", volume], capture_output=True, text=True).stdout
    return float(volume), json.loads(said)


def main():
    options = [a for a in sys.argv[1:] if a in ("--complete", "--diagram")]
    vcell, judge, *scenes = [a for a in sys.argv[1:] if a not in options]
    folder = pathlib.Path(__file__).resolve().parent.parent / "examples" / "scenes"
    all_good = True
    print("scene", "ok", "solids", "faces", "valid", "closed", "tolerance", "volume", "volume_off", "problems", sep="\t")
    with tempfile.TemporaryDirectory() as temporary:
        for scene in scenes or sorted(map(str, folder.glob("*.json"))):
            name = pathlib.Path(scene).stem
            volume, said = judged(vcell, judge, options, scene, str(pathlib.Path(temporary) / f"{name}.step"))
            good = volume is not None and bool(said.get("ok"))
            all_good = all_good and good
            if volume is None or "as_written" not in said:
                print(name, "no", *["-"] * 7, said if volume is None else said.get("error"), sep="\t")
                continue
            shape = said["as_written"]
            off = "-" if "volume" not in shape else f"{abs(shape['volume'] - volume) / abs(volume):.1e}"
            print(name, "yes" if good else "no", shape["count"]["solids"], shape["count"]["faces"],
                  shape["valid"], shape["shell_closed"], f"{shape['tolerance']['max']:.1e}", f"{volume:.9g}", off,
                  "; ".join(said["problems"]), sep="\t", flush=True)
    sys.exit(0 if all_good else 1)


if __name__ == "__main__":
    main()
