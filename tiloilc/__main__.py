"""`python -m tiloilc`: the command line."""

from tiloilc.cli import main

if __name__ == "__main__":
    main()
