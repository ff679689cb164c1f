"""The stage `ensemble`: the sticks under many motions."""
