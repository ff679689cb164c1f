"""Which package may import which, read off the sources."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import impactfem

SOURCES = Path(impactfem.__file__).parent

FINITE_ELEMENTS = {"basix", "dolfinx", "ffcx", "petsc4py", "slepc4py", "ufl"}

# Below every package, and open to it: what knows nothing of the subject.
GROUND = {"", "system"}

# What each package may import besides; a package comes after those that it may import.
PACKAGES = {
    "_fenicsx": set(),
    "spectra": set(),
    "dynamics": set(),
    "records": set(),
    "case": {"dynamics", "records", "spectra"},
    "motion": {"case", "records", "spectra"},
    "sticks": {"dynamics"},
    "coupling": {"case", "dynamics", "records", "sticks"},
    "building": {"_fenicsx", "case", "dynamics"},
    "reduction": {"building", "case", "coupling", "dynamics", "spectra"},
    "device": {"case", "coupling", "dynamics", "spectra", "sticks"},
    "plot": {"case", "spectra"},
    "stages": {"case", "dynamics", "plot", "spectra"},
    "stages.building": {
        *("building", "case", "dynamics", "plot", "reduction", "stages", "sticks"),
    },
    "stages.reduce": {*("building", "case", "dynamics", "reduction", "stages", "stages.building")},
    "stages.calibrate": {
        *("building", "case", "coupling", "dynamics", "plot", "reduction", "stages"),
        *("stages.building", "stages.reduce", "sticks"),
    },
    "stages.pounding": {
        *("case", "coupling", "motion", "plot", "records", "reduction", "spectra", "stages"),
        *("stages.building", "stages.calibrate", "stages.reduce", "sticks"),
    },
    "stages.ensemble": {
        *("case", "coupling", "plot", "reduction", "spectra", "stages", "stages.building"),
        *("stages.calibrate", "stages.pounding", "stages.reduce", "sticks"),
    },
    "stages.transient": {
        *("building", "case", "coupling", "device", "dynamics", "motion", "plot", "reduction"),
        *("spectra", "stages", "stages.building", "stages.calibrate", "stages.pounding"),
        "stages.reduce",
    },
    "stages.device": {
        *("building", "case", "coupling", "device", "dynamics", "plot", "reduction"),
        *("spectra", "stages", "stages.building", "stages.calibrate", "stages.pounding"),
        *("stages.reduce", "stages.transient", "sticks"),
    },
    "stages.design": {
        *("case", "coupling", "dynamics", "motion", "plot", "reduction"),
        *("spectra", "stages", "stages.building", "stages.calibrate", "stages.device"),
        *("stages.ensemble", "stages.pounding", "stages.reduce", "stages.transient", "sticks"),
    },
    "stages.equipment": {
        *("building", "case", "device", "plot", "reduction", "spectra", "stages"),
        *("stages.device", "stages.pounding", "stages.reduce", "stages.transient"),
    },
    "stages.sensitivity": {
        *("case", "coupling", "dynamics", "motion", "plot", "reduction", "spectra", "stages"),
        *("stages.building", "stages.calibrate", "stages.device", "stages.ensemble"),
        *("stages.pounding", "stages.reduce", "stages.transient", "sticks"),
    },
    "report": {*("plot", "spectra", "stages", "stages.device", "stages.transient")},
    "run": {
        *("building", "case", "coupling", "device", "motion", "plot", "reduction", "report"),
        *("stages", "stages.building", "stages.calibrate", "stages.design", "stages.device"),
        *("stages.ensemble", "stages.equipment", "stages.pounding", "stages.reduce"),
        "stages.sensitivity",
        "stages.transient",
    },
    "fit": {
        *("building", "case", "coupling", "dynamics", "plot", "run", "stages"),
        *("stages.building", "stages.pounding", "sticks"),
    },
    "verify": {
        *("building", "case", "coupling", "device", "dynamics", "fit", "motion", "records"),
        *("reduction", "spectra", "stages.pounding", "stages.reduce"),
        *("stages.transient", "sticks"),
    },
    "study": {"case", "fit", "run", "stages"},
    "cli_help": {"case"},
    "explain": {"case", "fit", "run", "stages"},
    "examples": {"case", "fit"},
    "cli": {"case", "cli_help", "examples", "explain", "fit", "run", "study", "verify"},
    "__main__": {"cli"},
}


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


def imports(module, at_once=False):
    """All that a module names, or what is loaded at once: not in functions, nor for types.

    The package itself names its public functions for types alone.
    """
    nodes = TREES[module].body if at_once or not module else ast.walk(TREES[module])
    statements = (node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom))
    return {name for node in statements for name in names_in(node)}


def package_of(module):
    """The package of a module; each stage is one."""
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] == "stages" and _is_stage(parts[1:]) else parts[0]


def _is_stage(parts):
    return bool(parts) and (SOURCES / "stages" / parts[0]).is_dir()


def modules_in(package):
    return sorted(module for module in TREES if package_of(module) == package)


def importers(*packages):
    """Modules that import one of these packages or a part of it."""
    return {
        module
        for module in TREES
        if any(name.split(".")[0] in packages for name in imports(module))
    }


def test_packages_are_named_and_stand_above_what_they_import():
    assert {package_of(module) for module in TREES} == GROUND | set(PACKAGES)
    seen = set()
    for package, below in PACKAGES.items():
        assert below <= seen, package
        seen.add(package)


@pytest.mark.parametrize("package", [*sorted(GROUND), *PACKAGES])
def test_imports_point_downward(package):
    allowed = GROUND | PACKAGES.get(package, set()) | {package}
    stray = {
        f"{module} imports {name}"
        for module in modules_in(package)
        for name in within(imports(module))
        if package_of(name) not in allowed
    }
    assert not stray


def test_no_permission_is_left_over():
    unused = {
        (package, below)
        for package, allowed in PACKAGES.items()
        for below in allowed
        if not any(
            package_of(name) == below
            for module in modules_in(package)
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


def test_who_knows_what():
    """One file dolfinx; the command line alone `bench`, which is not installed; dynamics no ufl."""
    assert importers("dolfinx", "basix", "ffcx") == {"_fenicsx"}
    assert importers("bench") == {"cli"}
    assert not importers("ufl") & set(modules_in("dynamics"))
    assert importers("petsc4py") & set(modules_in("dynamics"))


@pytest.mark.parametrize(
    "package",
    [
        *("case", "records", "motion", "spectra", "sticks", "coupling", "device", "plot", "stages"),
        *("report", "run", "study", "explain", "examples", "cli"),
    ],
)
def test_loads_without_finite_elements(package):
    """Whatever comes along when its modules are loaded."""
    loaded, waiting = set(), set(modules_in(package))
    while waiting:
        module = waiting.pop()
        loaded.add(module)
        names = imports(module, at_once=True)
        assert not FINITE_ELEMENTS & {name.split(".")[0] for name in names}, module
        # A module's packages are loaded before it.
        parts = [name.split(".") for name in within(names)]
        packages = {".".join(part[:k]) for part in parts for k in range(len(part) + 1)}
        waiting |= {name for name in packages if name in TREES} - loaded
