"""A browser and a server for all tests of a module; whoever asks for the browser is skipped where there is none."""

import pytest

from explorer_pages import started
from serving import free_port, serving


@pytest.fixture(scope="module")
def browser(request):
    """Chromium, or what a test names by `BROWSERS`."""
    with started(getattr(request, "param", "chromium")) as found:
        yield found


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with serving("--port", str(free_port()), folder=tmp_path_factory.mktemp("explorer")) as found:
        yield found
