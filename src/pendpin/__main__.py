"""`python -m pendpin`: the command line."""

from pendpin.cli import main

if __name__ == "__main__":  # not in the processes that a sweep starts, which import this file again
    main()
