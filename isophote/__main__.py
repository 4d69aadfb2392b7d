"""python -m isophote: the command line."""

from isophote.cli import main

main()
