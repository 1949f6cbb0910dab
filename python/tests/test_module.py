"""What the module is like: interrupts, threads, progress, and stubs that say what is there."""
import ast
import inspect
import pathlib
import signal
import threading
import time

import numpy as np
import pytest

import vcell

box = vcell.Box((0, 0, 0), (1, 1, 1))


@pytest.fixture
def many(rng):
    """So many balls that their cells take seconds."""
    return vcell.DiagramScene(np.column_stack([rng.uniform(0, 1, (60000, 3)), np.zeros(60000)]), box)


class Interrupt:
    """Ctrl-C after a while, as the keyboard sends it."""

    def __enter__(self):
        self.timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
        signal.signal(signal.SIGINT, signal.default_int_handler)
        self.timer.start()

    def __exit__(self, *_):
        self.timer.cancel()


def test_ctrl_c_ends_a_diagram(many):
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt), Interrupt():
        vcell.diagram(many, threads=1)
        pytest.fail("it took less time than it takes to press Ctrl-C")
    interrupted = time.monotonic() - begin
    alone = vcell.diagram(vcell.DiagramScene([vcell.Sphere((0.5, 0.5, 0.5))], box))
    assert abs(alone.volume[0] - 1) <= alone.volume_error[0] < 1e-11
    assert interrupted < 20


def test_ctrl_c_ends_a_query(around_a_ball, rng):
    points = np.tile(rng.uniform(0, 10, (1000, 3)), (3000, 1))
    query = vcell.PointQuery(around_a_ball)
    with pytest.raises(KeyboardInterrupt), Interrupt():
        query(points)


def test_what_a_progress_function_raises_ends_the_computation(many):
    told = []

    def progress(fraction):
        told.append(fraction)
        if len(told) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        vcell.diagram(many, threads=1, progress=progress)
    assert len(told) == 3 and told == sorted(told) and 0 <= told[0] and told[-1] < 1


def test_stages_of_a_cell_are_told(around_a_ball):
    told = []
    vcell.cell(around_a_ball, progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told and told[0][0] in ("bisectors", "envelope", "patches") and 0 <= told[0][1] <= 1


def test_what_a_visit_raises_ends_the_diagram(balls):
    def visit(number, cell):
        raise KeyError(number)

    with pytest.raises(KeyError):
        vcell.diagram(vcell.DiagramScene(balls, [(0, 0, 0), (10, 10, 10)]), visit=visit)


def test_the_interpreter_runs_while_cells_are_computed(many):
    counted = [0]
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)

    def progress(fraction):
        if counted[0] > 20:
            raise StopIteration

    thread.start()
    try:
        with pytest.raises(StopIteration):
            vcell.diagram(many, threads=1, progress=progress)
    finally:
        stop.set()
        thread.join()


def test_threads_share_a_query(around_a_ball, rng):
    points = rng.uniform(0, 10, (3000, 3))
    query = vcell.PointQuery(around_a_ball)
    expected = query(points)
    results = [None] * 4
    threads = [threading.Thread(target=lambda i=i: results.__setitem__(i, query(points))) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for result in results:
        assert all(np.array_equal(a, b, equal_nan=a.dtype == float) for a, b in zip(expected, result))


def stub():
    return ast.parse((pathlib.Path(vcell.__file__).parent / "_vcell.pyi").read_text())


def names(signature):
    """Of a function's arguments, from the first line of its text: "cell(scene: ..., *, measure: bool = True) -> ..."."""
    depth, name, found = 0, "", []
    for c in signature[signature.index("(") + 1:]:
        if c in "[({<":
            depth += 1
        elif c in "])}>" and not name.endswith("-"):
            if depth == 0:
                break
            depth -= 1
        if c == "," and depth == 0:
            found.append(name)
            name = ""
        else:
            name += c
    found.append(name)
    return [n.split(":")[0].strip() for n in found if n.strip() and n.strip() not in ("*", "/")]


def test_stubs_say_what_is_there():
    public = {name: value for name, value in vars(vcell._vcell).items() if not name.startswith("_")}
    said = {}
    for node in stub().body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            said[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            said[node.target.id] = node
    assert said.keys() - {"__version__", "Object"} == public.keys()
    for name, value in public.items():
        if inspect.isclass(value) and not issubclass(value, Exception):
            members = {n for n in vars(value) if not n.startswith("_")}
            methods = {n.name: n for n in said[name].body if isinstance(n, ast.FunctionDef)}
            fields = {n.target.id for n in said[name].body if isinstance(n, ast.AnnAssign)}
            assert {n for n in methods if not n.startswith("_")} | fields == members, name
            pairs = [(methods[n], getattr(value, n)) for n in methods if callable(vars(value).get(n))]
            if "__init__" in methods:
                pairs.append((methods["__init__"], value.__init__))
        elif callable(value) and not inspect.isclass(value):
            pairs = [(said[name], value)]
        else:
            continue
        for node, function in pairs:
            if node.name.startswith("__") and node.name not in ("__init__", "__call__"):
                continue
            arguments = [a.arg for a in node.args.posonlyargs + node.args.args + node.args.kwonlyargs]
            actual = names(function.__doc__.splitlines()[0])
            assert [a for a in arguments if a != "self"] == [a for a in actual if a != "self"], f"{name}.{node.name}"


def test_everything_is_documented():
    for name, value in vars(vcell._vcell).items():
        if not name.startswith("_") and callable(value):
            assert value.__doc__ and len(value.__doc__.strip()) > 10, name
