"""Read a motion file with VTK and write what it found; VTK does not go with dolfinx in one process.

Run by test_export.py: `python read_motion.py FILE FOUND`.
"""

import pickle
import sys
from pathlib import Path

import numpy as np
import pyvista
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline


def main(path, found):
    reader = pyvista.get_reader(path).reader
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    times, fields, grid = [], {}, None
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        grid = pyvista.wrap(reader.GetOutputDataObject(0))
        times.append(reader.GetTimeValue())
        for name in ("displacement", "acceleration"):
            fields.setdefault(name, []).append(np.array(grid.point_data[name]))
    content = {
        "told": information.Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()),
        "times": times,
        "points": np.array(grid.points),
        "types": np.array(grid.celltypes),
        "cells": np.array(grid.cells),
        **{name: np.array(values) for name, values in fields.items()},
    }
    found.write_bytes(pickle.dumps(content))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
