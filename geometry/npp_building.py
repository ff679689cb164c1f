"""The mesh of the paper's building, with its report and its sections beside Appendix A.

    python geometry/npp_building.py [CASE.toml] [MESH.msh]

CASE.toml is npp_pair.toml of this folder unless another one is given, MESH.msh npp_building.msh.
"""

import argparse
from pathlib import Path

from impactfem.building.from_case import geometry_of, sections_of
from impactfem.building.generate import generate
from impactfem.building.geometry import storey_sections
from impactfem.building.mesh_report import MeshReport
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Case, FileMesh, load_case
from impactfem.plot.table import Cell, Table
from impactfem.system.errors import ImpactfemError


def main() -> None:
    """Write the mesh, print the report and the comparison."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    case_file = Path(__file__).with_name("npp_pair.toml")
    parser.add_argument("case", nargs="?", type=Path, default=case_file)
    parser.add_argument("mesh", nargs="?", type=Path, default=Path("npp_building.msh"))
    options = parser.parse_args()
    try:
        case = load_case(options.case)
        if case.structure is None or isinstance(case.structure.mesh, FileMesh):
            raise SystemExit(f"{options.case} has no structure with a generated mesh")
        generate(geometry_of(case), options.mesh, source=str(options.case))
        mesh = read_mesh(options.mesh)
    except ImpactfemError as error:
        raise SystemExit(str(error)) from error
    print(MeshReport.of(mesh, sections_of(case.structure, mesh)))
    print(f"\n{options.mesh} is written\n")
    print(_comparison(case).as_text())


def _comparison(case: Case) -> Table:
    """Sections of the walls and columns as drawn, each beside the one of the floor table."""
    drawn = storey_sections(geometry_of(case))
    rows: list[tuple[Cell, ...]] = []
    for floor in case.building(case.structure.building).floors:
        section = drawn.get(floor.floor)
        if section is not None:
            pairs = (
                (section.A, floor.A),
                (section.A_vy, floor.Avy),
                (section.A_vx, floor.Avx),
                (section.I_x, floor.Ix),
                (section.I_y, floor.Iy),
            )
            rows.append((floor.floor, section.cut, *(x for pair in pairs for x in pair)))
    columns = [("storey", ""), ("cut", "m")]
    for name, unit in (("A", "m2"), ("A_vy", "m2"), ("A_vx", "m2"), ("I_x", "m4"), ("I_y", "m4")):
        columns += [(name, unit), ("table", unit)]
    return Table(
        "sections",
        "Gross sections of the storeys, cut where bays leave least, and those of the floor table",
        tuple(columns),
        tuple(rows),
    )


if __name__ == "__main__":
    main()
