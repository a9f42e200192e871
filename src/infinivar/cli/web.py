"""The command that shows a study in the browser: serve."""

from __future__ import annotations

from typing import Annotated

import typer

from infinivar.console import flush, say


def serve(
    study: Annotated[
        str | None,
        typer.Argument(metavar="STUDY", help="Study file, or the name of a shipped study; by default hand_controller."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            "--port", min=1, max=65535, help="Port; by default 8642, or a free one if it is taken.", show_default=False
        ),
    ] = None,
    host: Annotated[
        str,
        typer.Option("--host", help="Address to listen on; wider than this machine, the printed address has a token."),
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
) -> None:
    """Explore a study in the browser.

    Move a slider, and maps, powers and motions follow.
    Needs the extra web: pip install 'infinivar[web]'. Prints the address of the page; Ctrl-C stops.
    """
    from infinivar.web.server.start import serve as run

    def show(line: str) -> None:
        say(line)
        flush()

    run(study, host=host, port=port, say=show, opened=_open if browser else None)


def _open(address: str) -> None:
    """Open a browser, if there is one; the address is on the terminal in any case."""
    import webbrowser

    webbrowser.open(address)
