"""Run the command line as ``python -m infinivar``."""

from infinivar.cli import main

main()
