"""Linear dynamics of large models: matrices of PETSc in, arrays out."""
