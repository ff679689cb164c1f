import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.mesh import Part, areas
from impactfem.building.read_mesh import (
    Block,
    RawMesh,
    assemble,
    read_groups,
    read_mesh,
    read_raw,
)
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.system.executor import in_own_process

pytestmark = pytest.mark.usefixtures("gmsh_each_time")
KINDS = {"Point": 15, "Line 3": 8, "Triangle 6": 9}


def msh2(raw):
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
    path = tmp_path / "deux bâtiments.msh"
    path.write_text(msh2(replace(small_raw, nodes=1e3 * small_raw.nodes)))
    with pytest.raises(InputError, match=r"bâtiments\.msh: floor_1: .*is"):
        read_mesh(path)
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


def test_groups_that_share_an_entity_in_format_2(small_raw, tmp_path):
    """Gmsh gives all groups of an entity number to all of its cells."""
    text = msh2(small_raw).splitlines()
    start = text.index("$Elements") + 2
    for i in range(start, len(text) - 1):
        words = text[i].split()
        words[4] = "1"
        text[i] = " ".join(words)
    path = tmp_path / "two.msh"
    path.write_text("\n".join(text) + "\n")
    with pytest.raises(InputError, match=r"two groups.*format 2"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "the file is empty"),
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


def test_a_folder_and_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="this is a directory"):
        read_mesh(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        read_mesh(tmp_path / "none.msh")


@pytest.mark.parametrize("read", [read_mesh, read_groups])
def test_a_file_that_is_too_large(tmp_path, read):
    path = tmp_path / "large.msh"
    with path.open("wb") as stream:
        stream.write(b"$MeshFormat\n4.1 0 8\n")
        stream.truncate(10**12)  # sparse
    with pytest.raises(InputError, match="1000 GB; expected"):
        read(path)


@pytest.mark.parametrize(
    ("number", "missing"),
    [
        ("99999999999", "floor_2 to floor_99999999998"),
        ("999999999999999999", "floor_2 to floor_999999999999999998"),
        ("4", "floor_2 to floor_3"),
        ("3", "floor_2"),
    ],
)
def test_missing_levels_are_a_range(number, missing, frame_file, tmp_path):
    path = tmp_path / "high.msh"
    path.write_text(frame_file.read_text().replace("floor_2", f"floor_{number}"))
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    floors = [fault for fault in caught.value.faults if fault.key.startswith("floor_")]
    assert [fault.key for fault in floors] == [missing]
    assert len(caught.value.faults) < 10


def test_a_number_that_no_level_has(frame_file, tmp_path):
    path = tmp_path / "high.msh"
    path.write_text(frame_file.read_text().replace("floor_2", f"floor_{'9' * 5000}"))
    with pytest.raises(InputError, match=r"physical group|gmsh"):
        read_mesh(path)


MERGE = "import gmsh, sys; gmsh.initialize(readConfigFiles=False); gmsh.merge(sys.argv[1])"


@pytest.mark.parametrize("read", [read_mesh, read_groups])
def test_a_script_next_to_a_mesh_is_not_run(read, frame_file, tmp_path):
    path, effect = tmp_path / "building.msh", tmp_path / "effect"
    path.write_bytes(frame_file.read_bytes())
    Path(f"{path}.opt").write_text(f'SystemCall "touch {effect}";\n')
    read(path)
    assert not effect.exists()
    subprocess.run([sys.executable, "-c", MERGE, path], check=True, capture_output=True)
    assert effect.exists()  # gmsh runs it where it reads the file in place


@pytest.mark.parametrize(
    "start",
    [
        "",
        "// $MeshFormat\n4.1 0 8\n",
        "$MeshFormat 4.1\n",
        "$MeshFormat 4.1\r",
        "$MeshFormat\0\n4.1 0 8\n$EndMeshFormat\n",
        "$MeshFormatted\n4.1 0 8\n",
        "$Comments\n$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$EndComments\n",
        "$Comments $MeshFormat 4.1\n$EndComments\n",
        f"$Comments {'x' * 300}\n$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
    ],
)
def test_a_script_under_the_name_of_a_mesh_is_not_run(start, tmp_path):
    path, effect = tmp_path / "script.msh", tmp_path / "effect"
    path.write_text(f'{start}SystemCall "touch {effect}";\n', newline="")
    with pytest.raises(InputError, match=r"script\.msh"):
        read_mesh(path)
    assert not effect.exists()
    if not start:
        subprocess.run([sys.executable, "-c", MERGE, path], check=True, capture_output=True)
        assert effect.exists()


def test_no_space_for_the_copy_of_a_mesh(frame_file, tmp_path, monkeypatch):
    """The message names the folder of temporary files; the mesh is not at fault."""
    for name in ("TMPDIR", "TEMP", "TMP"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    with pytest.raises(ImpactfemError, match=r"temporary files: .*TMPDIR") as caught:
        read_raw(frame_file)
    assert not isinstance(caught.value, InputError) and str(frame_file) not in str(caught.value)


@pytest.mark.parametrize("part", [0.01, 0.3, 0.95])
def test_a_file_that_is_cut_off(part, frame_file, tmp_path):
    text = frame_file.read_text()
    path = tmp_path / "cut.msh"
    path.write_text(text[: int(part * len(text))])
    with pytest.raises(InputError, match=r"cut\.msh: .*expected"):
        read_mesh(path)


def test_a_group_without_a_name(frame_file, tmp_path):
    text = frame_file.read_text()
    lines = [line for line in text.splitlines() if '"floor_1"' not in line]
    count = lines.index("$PhysicalNames") + 1
    lines[count] = str(int(lines[count]) - 1)
    path = tmp_path / "nameless.msh"
    path.write_text("\n".join(lines) + "\n")
    raw = in_own_process(read_raw, path)
    with pytest.raises(InputError, match=r"number \d+: unknown physical"):
        assemble(raw, path)


def test_a_name_that_is_no_text(frame_file, tmp_path):
    path = tmp_path / "latin.msh"
    path.write_bytes(frame_file.read_bytes().replace(b"storey_1_west", b"storey_1_\xe9st"))
    with pytest.raises(InputError, match="not UTF-8"):
        read_mesh(path)


FILE = Path("own.msh")
PLACE = r"\(-?\d+\.\d{3}, -?\d+\.\d{3}, -?\d+\.\d{3}\) m"


def renamed(raw, names):
    """The mesh with groups that have another name, or, with None, are not there."""
    blocks = []
    for block in raw.blocks:
        groups = [names.get(group, group) for group in block.groups]
        blocks.append(replace(block, groups=tuple(group for group in groups if group)))
    every = [(names.get(group, group), dimension) for group, dimension in raw.groups]
    return RawMesh(raw.nodes, tuple(blocks), tuple((g, d) for g, d in every if g))


def without(raw, *groups):
    """The mesh without the cells of some groups."""
    blocks = tuple(block for block in raw.blocks if not set(block.groups) & set(groups))
    kept = tuple((g, d) for g, d in raw.groups if g not in groups)
    return RawMesh(raw.nodes, blocks, kept)


def edited(raw, group, **changes):
    blocks = tuple(replace(b, **changes) if group in b.groups else b for b in raw.blocks)
    return replace(raw, blocks=blocks)


def faults(raw):
    with pytest.raises(InputError) as caught:
        assemble(raw, FILE)
    assert {fault.file for fault in caught.value.faults} == {FILE}
    return [f"{fault.key}: {fault.expected}" for fault in caught.value.faults]


def test_the_mesh_as_it_is(small_raw):
    mesh = assemble(small_raw, FILE)
    assert Part("floor", 2, "parapet") in mesh.shell_parts
    assert len(mesh.dropped) == 0
    assert mesh.triangles.max() < len(mesh.nodes)
    np.testing.assert_array_equal(
        np.unique(np.concatenate([mesh.triangles.ravel(), mesh.lines.ravel()])),
        np.arange(len(mesh.nodes)),
    )


@pytest.mark.parametrize(
    ("missing", "expected"),
    [
        ("base", "base: missing group; expected the lines or points that are clamped"),
        ("edge_1", "edge_1: missing group; expected the lines of the slab's edge"),
        ("centre_2", "centre_2: missing group; expected the node at the floor's mass centre"),
        ("floor_1", "floor_1: missing group; floor_2 is above it"),
        ("floor", "floor_1: missing group; expected the slabs as floor_<k>"),
        (
            ("storey_2", "column_2"),
            "storey_2: missing group; expected walls or columns below floor_2",
        ),
        (
            ("storey", "column"),
            "storey_1: missing group; expected walls as storey_<k> or columns as column_<k>",
        ),
    ],
)
def test_missing_groups(small_raw, missing, expected):
    groups = [group for group, _ in small_raw.groups if group.startswith(missing)]
    found = faults(without(small_raw, *groups))
    assert len(found) == 1 or missing == ("storey", "column")
    assert any(fault.startswith(expected) for fault in found)
    if missing == ("storey_2", "column_2"):  # a storey of columns alone is one
        walls = [group for group in groups if group.startswith("storey")]
        assert assemble(without(small_raw, *walls), FILE).floors == (1, 2)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            lambda raw: renamed(raw, {"storey_1_inner": "wall_1_inner"}),
            [r"wall_1_inner: unknown physical group; expected floor_<k>\[_<part>\]"],
        ),
        (
            lambda raw: renamed(
                raw, {"storey_1_inner": "beam_1_inner", "beam_1_rim": "storey_1_rim"}
            ),
            [
                "storey_1_rim: a group of lines; expected surfaces",
                "beam_1_inner: a group of surfaces; expected lines",
            ],
        ),
        (
            lambda raw: renamed(raw, {"beam_2_face": "beam_3_face", "edge_2": "edge_4"}),
            [
                "edge_2: missing group; expected the lines of the slab's edge that faces the other",
                "beam_3_face: expected a number from 1 to 2, that of the top floor",
                "edge_4: expected a number from 1 to 2, that of the top floor",
            ],
        ),
        *(
            (
                lambda raw, group=group: renamed(raw, {group: None}),
                [rf": \d+ cells of {kind} without a physical group, the first at {PLACE}"],
            )
            for group, kind in (("storey_1_inner", "surfaces"), ("beam_1_oblique", "lines"))
        ),
        (
            lambda raw: edited(raw, "storey_1_inner", groups=("floor_1", "storey_1_inner")),
            [rf"floor_1, storey_1_inner: \d+ cells, the first at {PLACE}: in two groups"],
        ),
        (
            lambda raw: edited(raw, "storey_1_inner", kind="Quadrilateral 9"),
            ["storey_1_inner: .*expected triangles with 6 nodes and lines with 3$"],
        ),
        (
            lambda raw: renamed(raw, {"edge_1": "edge_2", "edge_2": "edge_1"}),
            [
                rf"edge_{k}: at {PLACE}: expected lines that are sides of triangles of floor_{k}$"
                for k in (1, 2)
            ],
        ),
        (
            lambda raw: renamed(raw, {"centre_1": "centre_2", "centre_2": "centre_1"}),
            [
                rf"centre_{k}: at \(4.000, 2.500, {z}\) m: expected a node of floor_{k} "
                r"\(in gmsh: a point embedded"
                for k, z in ((1, "5.800"), (2, "3.000"))
            ],
        ),
        (
            lambda raw: replace(
                raw, blocks=(*raw.blocks, Block(0, "Point", np.array([[5]]), ("centre_1",)))
            ),
            [rf"centre_1: at {PLACE}: 2 nodes; expected one$"],
        ),
    ],
)
def test_groups_that_are_refused(small_raw, change, expected):
    found = faults(change(small_raw))
    assert len(found) == len(expected), found
    for fault, words in zip(found, expected, strict=True):
        assert re.match(words, fault), fault


def test_points_without_a_group_are_let_be(small_raw):
    corner = Block(0, "Point", np.array([[5]]), ())
    mesh = assemble(replace(small_raw, blocks=(*small_raw.blocks, corner)), FILE)
    assert len(mesh.centres) == 2


def test_a_line_may_be_a_beam_an_edge_and_the_base(small_raw):
    """As in the generated mesh: the beam on the face is the impact edge as well."""
    shared = [b.groups for b in small_raw.blocks if len(b.groups) > 1]
    assert ("beam_2_face", "edge_2") in shared
    mesh = assemble(small_raw, FILE)
    on_face = mesh.lines[mesh.line_part == mesh.beam_parts.index(Part("beam", 2, "face"))]
    np.testing.assert_array_equal(np.unique(on_face), np.unique(mesh.edges[2]))


def test_first_order(small_raw):
    blocks = tuple(
        replace(b, nodes=b.nodes[:, : b.dimension + 1], kind=kind)
        for b in small_raw.blocks
        for kind in [("Point", "Line 2", "Triangle 3")[b.dimension]]
    )
    (fault,) = faults(replace(small_raw, blocks=blocks))
    assert "first-order cells," in fault
    assert "order (gmsh -order 2" in fault


def test_a_base_of_points_alone(small_raw, small_mesh):
    points = Block(0, "Point", np.array([[3], [1]]), ("base",))
    raw = without(small_raw, "base")
    mesh = assemble(
        RawMesh(raw.nodes, (*raw.blocks, points), (*raw.groups, ("base", 0))), FILE
    )  # fmt: skip
    np.testing.assert_array_equal(mesh.base, [1, 3])


def test_a_base_off_the_structure(small_raw):
    nodes = np.vstack([small_raw.nodes, [4.0, 4.0, -1.0]])
    point = Block(0, "Point", np.array([[len(small_raw.nodes)]]), ("base",))
    raw = replace(small_raw, nodes=nodes, blocks=(*small_raw.blocks, point))
    (fault,) = faults(raw)
    assert fault.startswith("base: at (4.000, 4.000, -1.000) m: ")


def test_the_shipped_mesh(frame):
    assert frame.floors == (1, 2)
    assert frame.elevations == pytest.approx({1: 3.0, 2: 6.0})
    assert 300 < len(frame.triangles) + len(frame.lines) < 1000
    assert [part.group for part in frame.shell_parts] == [
        "floor_1", "floor_2", "storey_1_west", "storey_2_west"
    ]  # fmt: skip
    area = areas(frame.nodes, frame.triangles)
    assert area.sum() == pytest.approx(2 * 6.0 * 4.0 + 2 * 4.0 * 3.0)
    # The wall's foot and the feet of two columns.
    feet = frame.nodes[frame.base]
    assert sorted({tuple(p) for p in feet[feet[:, 0] > 1.0].round(9)}) == [(6, 0, 0), (6, 4, 0)]
    assert np.ptp(feet[feet[:, 0] < 1.0][:, 1]) == pytest.approx(4.0)
