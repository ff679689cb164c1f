"""Settings of the documentation: `scripts/docs` builds it."""

from __future__ import annotations

import sys
from pathlib import Path

import impactfem

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "impactfem"
author = copyright = "The impactfem developers"
release = version = impactfem.__version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_design",
    "docstrings",
    "mathml",
]
exclude_patterns = ["_build", "_ext"]
nitpicky = True
highlight_language = "none"

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4

# Whatever is compiled or large is not imported: the pages can be built where FEniCSx is missing.
autodoc_mock_imports = [
    "basix", "dolfinx", "gmsh", "h5py", "mpi4py", "numba", "petsc4py", "pyvista", "slepc4py",
    "ufl", "vtk",
]  # fmt: skip
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False

toc_object_entries = False

html_theme = "furo"
html_title = f"impactfem {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["math.css", "tables.css", "pages.css"]
html_copy_source = False
html_show_sourcelink = False
