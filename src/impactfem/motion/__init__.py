"""Ground motion: treatment of records, design spectra, synthesis, acceptance."""
