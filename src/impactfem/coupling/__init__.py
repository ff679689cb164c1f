"""Bodies, links and contact laws; pounding of sticks, unilateral contact, impacts."""
