"""Meshes that are generated and read once: gmsh, in a process of its own, takes a second."""

import hashlib
import pickle

from impactfem.building import generate, read_mesh


def keep_meshes(patch):
    """Keep the meshes of gmsh by their geometry, and what is read of a file by its content.

    Errors are not kept: their messages name the file.
    """
    made, raw = {}, {}

    def generated(function, geometry, path, source, binary):
        key = pickle.dumps((geometry, binary))
        if key not in made:
            OWN.generate(function, geometry, path, source, binary)
            made[key] = path.read_bytes()
        path.write_bytes(made[key])

    def read(function, path, what):
        key = hashlib.sha256(path.read_bytes()).digest()
        if key not in raw:
            raw[key] = pickle.dumps(OWN.read(function, path, what))
        return pickle.loads(raw[key])

    patch.setattr(generate, "in_own_process", generated)
    patch.setattr(read_mesh, "read_in_own_process", read)


class OWN:
    """What the program does."""

    generate = staticmethod(generate.in_own_process)
    read = staticmethod(read_mesh.read_in_own_process)


def start_gmsh(patch):
    """Start gmsh for each mesh, as the program does."""
    patch.setattr(generate, "in_own_process", OWN.generate)
    patch.setattr(read_mesh, "read_in_own_process", OWN.read)
