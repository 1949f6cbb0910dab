"""The README's piece of Python does what it says."""
import pathlib
import re

import numpy as np

import vcell

source = pathlib.Path(__file__).parents[2]


def test_the_piece_in_the_readme(tmp_path, monkeypatch, capsys):
    pieces = re.findall(r"```python\n(.*?)```", (source / "README.md").read_text(), re.S)
    assert len(pieces) == 1
    (tmp_path / "tests").symlink_to(source / "tests")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(pieces[0], names)
    assert names["owner"].tolist() == [0, 1] and names["inside"].tolist() == [True, False]
    assert names["points"].shape == (2, 3) and len(names["contacts"]) == 2420
    # The points of the patch are as far from the floor as from the ball.
    ball = names["balls"][names["cell"].faces[0].site.index]
    gap = np.linalg.norm(names["points"] - ball[:3], axis=1) - ball[3] - names["points"][:, 2]
    assert np.abs(gap).max() < 1e-12
    assert (tmp_path / "cell.obj").exists()
    assert capsys.readouterr().out.startswith("2.")
    assert vcell.__version__ in (source / "CMakeLists.txt").read_text()
