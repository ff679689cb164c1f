"""Read mesh files with gmsh loaded once, each in a process of its own; what each gave, as pickle.

    python raw_meshes.py FOLDER

For each file there is one beside it with the ending `.pickle`, if gmsh came to an end.
"""

import os
import pickle
import sys
from pathlib import Path

import gmsh  # noqa: F401

from impactfem.building.read_mesh import read_raw
from impactfem.system.errors import InputError

for path in sorted(Path(sys.argv[1]).glob("*.msh")):
    if os.fork() == 0:
        try:
            found = read_raw(path)
        except InputError as error:
            found = error
        path.with_suffix(".pickle").write_bytes(pickle.dumps(found))
        os._exit(0)
    os.wait()
