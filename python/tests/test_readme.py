"""The pieces of Python in the README and in docs/library.md do what they say."""
import pathlib
import re

import numpy as np

import vcell

source = pathlib.Path(__file__).parents[2]


def run_piece(page, folder, monkeypatch):
    """The names that the page's only piece of Python leaves, run beside tests/."""
    pieces = re.findall(r"```python\n(.*?)```", (source / page).read_text(encoding="utf-8"), re.S)
    assert len(pieces) == 1
    (folder / "tests").symlink_to(source / "tests")
    monkeypatch.chdir(folder)
    names = {}
    exec(pieces[0], names)
    return names


def test_the_piece_in_the_readme(tmp_path, monkeypatch, capsys):
    names = run_piece("README.md", tmp_path, monkeypatch)
    assert names["cell"].neighbors.tolist() == [0, 1] and len(names["diagram"].contacts().area) == 2420
    assert capsys.readouterr().out.count("[") > 2


def test_the_piece_in_the_library_page(tmp_path, monkeypatch, capsys):
    names = run_piece("docs/library.md", tmp_path, monkeypatch)
    assert names["owner"].tolist() == [0, 1] and names["inside"].tolist() == [True, False]
    assert names["points"].shape == (2, 3) and len(names["contacts"]) == 2420
    # The points of the patch are as far from the floor as from the ball.
    ball = names["balls"][names["cell"].faces[0].site.index]
    gap = np.linalg.norm(names["points"] - ball[:3], axis=1) - ball[3] - names["points"][:, 2]
    assert np.abs(gap).max() < 1e-12
    assert (tmp_path / "cell.obj").exists()
    assert capsys.readouterr().out.startswith("2.")
    assert vcell.__version__ in (source / "CMakeLists.txt").read_text()
