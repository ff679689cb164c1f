"""The rooms of the package and the rules of the house: who may import whom, read off the text."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import impactfem

SOURCES = Path(impactfem.__file__).parent

FINITE_ELEMENTS = {"basix", "dolfinx", "ffcx", "petsc4py", "slepc4py", "ufl"}

# Below every room, and open to it: what knows nothing of the subject.
GROUND = {
    *("", "archive", "cache", "errors", "file_errors", "files", "log", "memory", "own_process"),
    *("parallel", "scalar", "stop"),
}

# What each room may import besides; a room comes after those that it may import.
ROOMS = {
    "_fenicsx": set(),
    "spectra": set(),
    "dynamics": set(),
    "case": {"spectra"},
    "motion": {"case", "spectra"},
    "sticks": {"case", "motion", "spectra"},
    "device": {"case", "dynamics", "spectra", "sticks"},
    "building": {"_fenicsx", "case", "dynamics"},
    "transient": {"building", "case", "dynamics", "motion", "spectra", "sticks"},
    "wall": {"building", "case", "dynamics", "sticks", "transient"},
    "equipment": {
        *("building", "case", "device", "dynamics", "motion", "spectra"),
        *("sticks", "transient", "wall"),
    },
    "design": {"building", "case", "equipment", "motion", "spectra", "sticks", "transient"},
    "results": {"case", "spectra"},
    "report": {"results", "spectra"},
    "verify": {
        *("building", "case", "device", "dynamics", "motion", "spectra"),
        *("results", "sticks", "transient", "wall"),
    },
    "bench": {
        *("building", "case", "dynamics", "motion", "spectra", "sticks"),
        *("transient", "verify", "wall"),
    },
    "study": {
        *("building", "case", "design", "device", "equipment", "motion", "report", "results"),
        *("sticks", "transient", "wall"),
    },
    "cli": {"bench", "case", "study", "verify"},
}

# Results read stores, never solvers: these say what a name or a history in a store means.
VALUES_IN_STORES = {"building.part", "wall.history", "wall.impact"}


def module_of(path):
    """Dotted name below the package: "sticks.stick", "sticks" for its __init__, "" for the top."""
    parts = path.relative_to(SOURCES).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


TREES = {
    module_of(path): ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES.rglob("*.py")
}


def names_in(node):
    """What one import statement names: modules of the package where they are, else as written."""
    if isinstance(node, ast.Import):
        return {name.name for name in node.names}
    below = {f"{node.module}.{name.name}" for name in node.names}
    ours = {name for name in below if name.removeprefix("impactfem.") in TREES}
    return ours | ({node.module} if ours != below else set())


def within(names):
    """Those of the names that are the package's own, below it."""
    return {
        name.removeprefix("impactfem").lstrip(".")
        for name in names
        if name.split(".")[0] == "impactfem"
    }


def imports(module):
    """All that a module names, in functions and for types too."""
    statements = (
        node for node in ast.walk(TREES[module]) if isinstance(node, ast.Import | ast.ImportFrom)
    )
    return {name for node in statements for name in names_in(node)}


def at_once(module):
    """What is loaded when a module is: neither what a function asks for, nor what types need."""
    return {
        name
        for node in TREES[module].body
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in names_in(node)
    }


def room_of(module):
    return module.split(".")[0]


def modules_in(room):
    return sorted(module for module in TREES if room_of(module) == room)


def importers(*packages):
    """Modules that import one of these packages or a part of it."""
    return {
        module
        for module in TREES
        if any(name.split(".")[0] in packages for name in imports(module))
    }


def test_every_room_is_named():
    assert {room_of(module) for module in TREES} == GROUND | set(ROOMS)


def test_rooms_stand_above_what_they_import():
    seen = set()
    for room, below in ROOMS.items():
        assert below <= seen, room
        seen.add(room)


@pytest.mark.parametrize("room", ROOMS)
def test_imports_point_downward(room):
    allowed = GROUND | ROOMS[room] | {room}
    stray = {
        f"{module} imports {name}"
        for module in modules_in(room)
        for name in within(imports(module))
        if room_of(name) not in allowed and not (room == "results" and name in VALUES_IN_STORES)
    }
    assert not stray


@pytest.mark.parametrize("room", sorted(GROUND))
def test_ground_carries_itself(room):
    assert {
        room_of(name) for module in modules_in(room) for name in within(imports(module))
    } <= GROUND


def test_no_permission_is_left_over():
    unused = {
        (room, below)
        for room, allowed in ROOMS.items()
        for below in allowed
        if not any(
            room_of(name) == below
            for module in modules_in(room)
            for name in within(imports(module))
        )
    }
    assert not unused


def test_no_circles():
    graph = {module: within(imports(module)) - {module} for module in TREES}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_one_file_knows_dolfinx():
    assert importers("dolfinx", "basix", "ffcx") == {"_fenicsx"}


def test_dynamics_knows_matrices_only():
    assert "ufl" not in {name for module in modules_in("dynamics") for name in imports(module)}
    assert importers("petsc4py") & set(modules_in("dynamics"))


@pytest.mark.parametrize(
    "room", ["case", "motion", "spectra", "sticks", "device", "results", "report", "cli", "study"]
)
def test_loads_without_finite_elements(room):
    """Whatever comes along when its modules are loaded."""
    loaded, waiting = set(), set(modules_in(room))
    while waiting:
        module = waiting.pop()
        loaded.add(module)
        names = at_once(module)
        assert not FINITE_ELEMENTS & {name.split(".")[0] for name in names}, module
        # A module's packages are loaded before it.
        parts = [name.split(".") for name in within(names)]
        packages = {".".join(part[:k]) for part in parts for k in range(len(part) + 1)}
        waiting |= {name for name in packages if name in TREES} - loaded
