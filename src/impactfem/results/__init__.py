"""What a person gets: the summary, tables and figures, made from the stores."""
