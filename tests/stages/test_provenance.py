import platform
import sys
from importlib.metadata import PackageNotFoundError

import numpy as np

from impactfem import __version__
from impactfem.stages import provenance as module
from impactfem.stages.provenance import PACKAGES, provenance


def test_versions_and_facts(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/usr/bin/impactfem", "run", "a b.toml"])
    found = provenance(case="a.toml", seeds={"motions[0].seed": 1})
    assert found["impactfem"] == __version__ and found["packages"]["numpy"] == np.__version__
    assert set(found["packages"]) == set(PACKAGES)
    assert found["python"] == platform.python_version()
    assert found["command"] == ["impactfem", "run", "a b.toml"]
    assert found["case"] == "a.toml" and found["seeds"] == {"motions[0].seed": 1}
    assert platform.node() not in str(found)


def test_a_package_that_is_not_installed(monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(module, "version", absent)
    assert set(provenance()["packages"].values()) == {"unknown"}
