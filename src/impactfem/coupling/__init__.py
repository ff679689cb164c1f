"""What touches: contact laws, sticks that pound, unilateral contact, impacts, energy."""
