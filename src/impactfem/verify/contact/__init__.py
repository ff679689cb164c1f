"""Contact between sticks and unilateral contact."""
