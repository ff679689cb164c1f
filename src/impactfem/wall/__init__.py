"""The impact of one building on a rigid wall: experiment, stick on the penalty law, evaluation."""
