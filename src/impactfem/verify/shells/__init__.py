"""Shells and beams."""
