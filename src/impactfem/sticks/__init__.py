"""Stick models of buildings, and what happens when they pound."""
