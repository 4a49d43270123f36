"""``python -m worldgen``: run the program if ``worldgen`` is not on the path."""

from worldgen.cli.main import main

main()
