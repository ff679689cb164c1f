"""The index of a motion file in XDMF: says where in it grid, times and fields are."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray

from impactfem.reduction.probes import MotionGrid
from impactfem.system.files import atomic

Array = NDArray[np.float64]
Index = NDArray[np.int64]

TOPOLOGY = "XDMF/Topology"
POINTS = "VTKHDF/Points"
FIELDS = "VTKHDF/PointData"
"""Where arrays are in the motion file."""
TRIANGLES = {3: (4,), 6: (36,)}
LINES = {2: (2, 2), 3: (34,)}
"""What comes before the nodes of each cell, by their number: the type; of a polyline that, too."""


def mixed_topology(grid: MotionGrid) -> Index:
    """All cells in one row, each with its type before its nodes."""
    rows = []
    for cells, kinds in ((grid.triangles, TRIANGLES), (grid.lines, LINES)):
        before = np.tile(kinds[cells.shape[1]], (len(cells), 1))
        rows.append(np.hstack([before, cells]).ravel())
    return np.concatenate(rows)


def write_motion_index(
    path: Path, motion: Path, grid: MotionGrid, times: Array, fields: tuple[str, ...]
) -> None:
    """Write the index.

    Args:
        path: The file.
        motion: The motion file, in the same folder.
        grid: Its cells.
        times: Its times [s].
        fields: Names of its fields.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    n = len(grid.nodes)
    root = Element("Xdmf", Version="3.0")
    series = SubElement(
        SubElement(root, "Domain"),
        "Grid",
        Name="motion",
        GridType="Collection",
        CollectionType="Temporal",
    )
    entries = len(mixed_topology(grid))
    for k, time in enumerate(times):
        at = SubElement(series, "Grid", Name="building", GridType="Uniform")
        SubElement(at, "Time", Value=f"{time:.12g}")
        topology = SubElement(
            at, "Topology", TopologyType="Mixed", NumberOfElements=str(grid.cells)
        )
        _array(topology, motion, TOPOLOGY, str(entries), "Int", 8)
        _array(SubElement(at, "Geometry", GeometryType="XYZ"), motion, POINTS, f"{n} 3", "Float", 8)
        for name in fields:
            field = SubElement(at, "Attribute", Name=name, AttributeType="Vector", Center="Node")
            part = SubElement(field, "DataItem", ItemType="HyperSlab", Dimensions=f"{n} 3")
            where = SubElement(part, "DataItem", Dimensions="3 2", NumberType="Int", Format="XML")
            # First row and column, strides, numbers of rows and columns.
            where.text = f"{k * n} 0 1 1 {n} 3"
            _array(part, motion, f"{FIELDS}/{name}", f"{len(times) * n} 3", "Float", 4)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree, " ")
    with atomic(path) as temporary:
        tree.write(temporary, encoding="utf-8", xml_declaration=True)


def _array(
    parent: Element, motion: Path, place: str, shape: str, kind: str, precision: int
) -> None:
    item = SubElement(
        parent,
        "DataItem",
        Format="HDF",
        NumberType=kind,
        Precision=str(precision),
        Dimensions=shape,
    )
    item.text = f"{motion.name}:/{place}"
