"""The run: the loop over the stages, reuse, folder, sweep."""
