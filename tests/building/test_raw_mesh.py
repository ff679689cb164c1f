"""Files of gmsh: the formats, and what is none."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.read_mesh import assemble, read_mesh, read_raw
from impactfem.system.errors import InputError
from impactfem.system.own_process import in_own_process

KINDS = {"Point": 15, "Line 3": 8, "Triangle 6": 9}


def msh2(raw) -> str:
    """A mesh in gmsh's format 2: a cell of a block in two groups stands there twice."""
    numbers = {group: i + 1 for i, group in enumerate(raw.groups)}
    elements = []
    for entity, block in enumerate(raw.blocks, start=1):
        for name in block.groups:
            group = numbers[name, block.dimension]
            for cell in (block.nodes + 1).tolist():
                head = [len(elements) + 1, KINDS[block.kind], 2, group, entity]
                elements.append(" ".join(map(str, [*head, *cell])))
    names = [f'{dim} {number} "{name}"' for (name, dim), number in numbers.items()]
    nodes = [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(raw.nodes.tolist(), 1)]
    sections = {"PhysicalNames": names, "Nodes": nodes, "Elements": elements}
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    for name, content in sections.items():
        lines += [f"${name}", str(len(content)), *content, f"$End{name}"]
    return "\n".join(lines) + "\n"


def test_format_2_holds_the_same_mesh(small_raw, small_mesh, tmp_path):
    path = tmp_path / "two.msh"
    path.write_text(msh2(small_raw))
    mesh = read_mesh(path)
    assert mesh.shell_parts == small_mesh.shell_parts
    assert mesh.beam_parts == small_mesh.beam_parts
    assert mesh.centres == small_mesh.centres
    np.testing.assert_array_equal(mesh.nodes, small_mesh.nodes)
    np.testing.assert_array_equal(mesh.base, small_mesh.base)
    for name in ("triangles", "lines"):
        np.testing.assert_array_equal(
            np.unique(getattr(mesh, name), axis=0), np.unique(getattr(small_mesh, name), axis=0)
        )
    for k in (1, 2):
        found, known = (np.unique(m.edges[k], axis=0) for m in (mesh, small_mesh))
        np.testing.assert_array_equal(found, known)


def test_a_file_in_millimetres(small_raw, tmp_path):
    path = tmp_path / "mm.msh"
    path.write_text(msh2(replace(small_raw, nodes=1e3 * small_raw.nodes)))
    with pytest.raises(InputError, match=r"mm\.msh: floor_1: .*is it in millimetres"):
        read_mesh(path)


def test_a_node_of_no_cell_is_dropped(frame_file, tmp_path):
    """Format 4 keeps it on its entity; gmsh itself drops those of format 2."""
    lines = frame_file.read_text().splitlines()
    start = lines.index("$Nodes") + 1
    blocks, nodes, first, last = map(int, lines[start].split())
    dimension, entity, parametric, count = lines[start + 1].split()
    assert count == "1"
    lines[start : start + 4] = [
        f"{blocks} {nodes + 1} {first} {last + 1}",
        f"{dimension} {entity} {parametric} 2",
        lines[start + 2],
        str(last + 1),
        lines[start + 3],
        "1 1 9",
    ]
    path = tmp_path / "orphan.msh"
    path.write_text("\n".join(lines) + "\n")
    mesh = read_mesh(path)
    np.testing.assert_array_equal(mesh.dropped, [[1.0, 1.0, 9.0]])
    np.testing.assert_array_equal(mesh.nodes, read_mesh(frame_file).nodes)


def test_groups_that_share_an_entity_in_format_2_are_told(small_raw, tmp_path):
    """Gmsh gives all groups of an entity number to all of its cells."""
    text = msh2(small_raw).splitlines()
    start = text.index("$Elements") + 2
    for i in range(start, len(text) - 1):
        words = text[i].split()
        words[4] = "1"
        text[i] = " ".join(words)
    path = tmp_path / "two.msh"
    path.write_text("\n".join(text) + "\n")
    with pytest.raises(InputError, match=r"in two groups.*format 2"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", r"no \$MeshFormat"),
        ("Point(1) = {0, 0, 0};\n// $MeshFormat\n4.1 0 8\n", r"no \$MeshFormat"),
        ("$MeshFormat", r"no \$MeshFormat"),
        ("$MeshFormat\n1.0 0 8\n$EndMeshFormat\n", r"\$MeshFormat = '1\.0'"),
        ("$MeshFormat\n3.0 0 8\n$EndMeshFormat\n", "expected a mesh of gmsh"),
        ("solid\nfacet normal 0 0 1\n", "expected a mesh of gmsh"),
        ("\x00\x01\x02", "expected a mesh of gmsh"),
        ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "floor_1: missing group"),
    ],
)
def test_what_is_no_mesh(content, expected, tmp_path):
    path = tmp_path / "no.msh"
    path.write_text(content)
    with pytest.raises(InputError, match=expected) as caught:
        read_mesh(path)
    assert all(fault.file == path for fault in caught.value.faults)


@pytest.mark.parametrize("part", [0.01, 0.3, 0.6, 0.95])
def test_a_file_that_is_cut_off(part, frame_file, tmp_path):
    text = frame_file.read_text()
    path = tmp_path / "cut.msh"
    path.write_text(text[: int(part * len(text))])
    with pytest.raises(InputError, match=r"cut\.msh: .*expected a mesh of gmsh"):
        read_mesh(path)


def test_a_folder_and_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="Is a directory"):
        read_mesh(tmp_path)
    with pytest.raises(InputError, match="No such file"):
        read_mesh(tmp_path / "none.msh")


def test_a_name_with_spaces_and_accents(frame_file, tmp_path):
    path = tmp_path / "mon bâtiment.msh"
    path.write_bytes(frame_file.read_bytes())
    assert read_mesh(path).elements == read_mesh(frame_file).elements


def test_a_group_without_a_name(frame_file, tmp_path):
    text = frame_file.read_text()
    lines = [line for line in text.splitlines() if '"floor_1"' not in line]
    count = lines.index("$PhysicalNames") + 1
    lines[count] = str(int(lines[count]) - 1)
    path = tmp_path / "nameless.msh"
    path.write_text("\n".join(lines) + "\n")
    raw = in_own_process(read_raw, path)
    with pytest.raises(InputError, match=r"number \d+: unknown physical group; expected floor_<k>"):
        assemble(raw, path)


def test_a_name_that_is_no_text(frame_file, tmp_path):
    path = tmp_path / "latin.msh"
    path.write_bytes(frame_file.read_bytes().replace(b"storey_1_west", b"storey_1_\xe9st"))
    with pytest.raises(InputError, match=r"latin\.msh: a name that is not UTF-8"):
        read_mesh(path)
