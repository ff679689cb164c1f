"""Speed on this machine, as figures and ratios of one run."""
