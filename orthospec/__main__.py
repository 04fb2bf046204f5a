"""``python -m orthospec``: the same as the installed command."""

from orthospec.cli import main

main()
