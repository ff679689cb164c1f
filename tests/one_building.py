"""The building of a case with one 3D model."""


def building_of(case):
    """The building with a 3D model of a case, the first of several."""
    return next(iter(case.modelled.values()))
