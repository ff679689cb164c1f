"""Forces on the anchors of a cabinet on floor 2 of east, which is a stick, by its floor spectra.

python geometry/row_with_cabinet.py runs/row_with_cabinet
"""

import sys

from impactfem.device.models import TableMode, from_modes
from impactfem.device.parts import RigidBody
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.study import open_run

# Modes that a shaking table test gives; what they do not carry of 450 kg follows the floor.
modes = [TableMode(11.0, "y", 310.0, height=1.2), TableMode(31.0, "y", 90.0, height=0.7)]
body = RigidBody.at_height(450.0, 1.1, 150.0, 150.0, 40.0)
cabinet = from_modes("cabinet", modes, damping=0.04, body=body)

found = spectrum_analysis(cabinet, open_run(sys.argv[1]).anchor_spectra("east", 2))
for name in ("force y", "moment x"):
    print(f"{name}: {found.value(name):.0f}")
