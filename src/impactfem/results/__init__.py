"""What a person gets: the summary, tables and figures, made from the stores."""

from impactfem.results.run_folder import RunFolder, open_run

__all__ = ["RunFolder", "open_run"]
