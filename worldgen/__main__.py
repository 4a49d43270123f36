"""``python -m worldgen``: the program, for where ``worldgen`` is not on the path."""

from worldgen.cli.main import main

main()
