"""Runs without the figures that stages draw, which take most of the time of a small one."""

from impactfem.plot import floor_products
from impactfem.stages.building import stage as building
from impactfem.stages.calibrate import stage as calibrate
from impactfem.stages.design import stage as design
from impactfem.stages.device import stage as device
from impactfem.stages.ensemble import stage as ensemble
from impactfem.stages.pounding import stage as pounding
from impactfem.stages.transient import stage as transient

FIGURES = (
    (building, "in_own_process"),
    (calibrate, "wall_figures"),
    (pounding, "stick_figures"),
    (floor_products, "floor_figures"),
    (transient, "transient_figures"),
    (device, "device_figures"),
    (design, "design_figures"),
)
ENSEMBLE = (ensemble, "ensemble_results")


def no_pictures(patch, *further):
    """Leave out what the stages draw; a name that draws nothing is an error of the test."""
    for module, name in (*FIGURES, *further):
        patch.setattr(module, name, lambda *_, **__: [])
