"""The command line, killed while it writes one of its files.

Run by test_interruption.py: `python interrupted.py NAME CASE FOLDER [OPTION...]`, with options of
`impactfem run`; no file has the name "-".
"""

import os
import signal
import sys
from contextlib import contextmanager

from impactfem.cli import main
from impactfem.stages.drawing import Figures
from impactfem.stages.transient import export
from impactfem.system import files

whole = files.atomic
name, case, folder, *options = sys.argv[1:]


@contextmanager
def interrupted(path):
    """As `atomic`; the file at hand is only half there when the process ends."""
    with whole(path) as temporary:
        yield temporary
        if path.name == name:
            os.truncate(temporary, temporary.stat().st_size // 2)
            os.kill(os.getpid(), signal.SIGKILL)


for module in (files, export):
    module.atomic = interrupted
Figures.draw = lambda *_: []
sys.argv = ["impactfem", "run", case, "--stage", "transient", "--out", folder, *options]
main()
