"""What is free in a fit of the small measured building, and what is known of it."""

FREE = """
[free."materials.concrete.young_modulus"]
bounds = ["15 GPa", "45 GPa"]
scale = "log"
[free."buildings[0].second_moment_factor"]
bounds = [0.1, 2.0]
scale = "log"
"""
TARGETS = """
[[targets]]
result = "sticks.T.frequency.1"
value = "0.93 Hz"
[[targets]]
result = "sticks.T.frequency.2"
value = "3.4 Hz"
deviation = "1 %"
"""
