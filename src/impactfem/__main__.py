"""`python -m impactfem` is the program `impactfem`."""

from impactfem.cli import main

if __name__ == "__main__":
    main()
