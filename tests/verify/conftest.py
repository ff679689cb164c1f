"""What shell benchmarks are shown to see: models with something wrong."""

import inspect
from dataclasses import replace

import pytest

from impactfem.building import shell
from impactfem.building.shell_model import Shells


@pytest.fixture
def wrong(monkeypatch):
    """Replace a function of a module or class by one that takes the right one first."""

    def put(owner, name, altered):
        right = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *some, **named: altered(right, *some, **named))

    return put


@pytest.fixture
def scaled(wrong):
    """Multiply an argument of a function, by its name, in all calls that a module makes."""

    def scale(module, name, argument, factor):
        def called(right, *given, **named):
            bound = inspect.signature(right).bind(*given, **named)
            bound.arguments[argument] = factor * bound.arguments[argument]
            return right(*bound.args, **bound.kwargs)

        wrong(module, name, called)

    return scale


@pytest.fixture
def altered(wrong):
    """Multiply Young's modulus or the thickness of the models that a module makes."""

    def alter(module, E=1.0, thickness=1.0):
        def changed(part):
            changes = {"material": replace(part.material, E=E * part.material.E)}
            if isinstance(part, Shells):
                changes["thickness"] = thickness * part.thickness
            return replace(part, **changes)

        def altered(right, points, *parts, **options):
            return right(points, *map(changed, parts), **options)

        wrong(module, "shell_model", altered)

    return alter


@pytest.fixture(scope="session")
def wrong_forms(tmp_path_factory):
    """The folder of forms that are wrong on purpose."""
    return tmp_path_factory.mktemp("forms")


@pytest.fixture
def own_cache(monkeypatch, wrong_forms):
    """A cache for the forms of a test, which another test may have compiled."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(wrong_forms))


@pytest.fixture
def wrong_drilling(monkeypatch, own_cache):
    """Drilling energy of ω = ½ curl u + θ·e3."""

    class Strains(shell._Strains):
        def __init__(self, w, frame, *others):
            super().__init__(w, frame, *others)
            self.drilling += 2.0 * shell.ufl.dot(shell.halves(w)[1], frame[2])

    monkeypatch.setattr(shell, "_Strains", Strains)


@pytest.fixture
def partly_reduced(monkeypatch, own_cache):
    """Shear α γ·γ in full and (1 − α) γ·γ by three points, α = t²/(t² + h²), as it once was.

    Without a bubble quadratic triangles cannot follow that many conditions.
    """

    def stiffness(fields, space):
        ufl, mesh, t = shell.ufl, space.mesh, fields.thickness
        trial, test = (
            shell._Strains(w, shell._frame(mesh), mesh, fields)
            for w in (ufl.TrialFunction(space), ufl.TestFunction(space))
        )
        N, M, _ = trial.forces()
        shear = shell.SHEAR * fields.shear_modulus * t * ufl.inner(trial.shear, test.shear)
        drilling = fields.drilling * fields.shear_modulus * t * trial.drilling * test.drilling
        alpha = t**2 / (t**2 + ufl.CellDiameter(mesh) ** 2)
        few, many = (
            ufl.dx(mesh, metadata={"quadrature_degree": degree})
            for degree in (shell.REDUCED, shell.FULL)
        )
        plane = ufl.inner(N, test.membrane) + ufl.inner(M, test.bending)
        return (plane + (1.0 - alpha) * shear) * few + (alpha * shear + drilling) * many

    monkeypatch.setattr(shell.ShellFields, "stiffness", stiffness)


@pytest.fixture
def failed():
    """Quantities of the rows that do not pass."""
    return lambda rows: {row.quantity for row in rows if not row.passed}
