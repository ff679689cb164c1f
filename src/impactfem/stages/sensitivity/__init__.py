"""The stage `sensitivity`: how the demands of the verdicts change with single parameters."""
