"""``python -m orthospec``."""

from orthospec.cli import main

main()
