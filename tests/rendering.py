"""Saved figures: rendered, or blank where a test looks at names or words alone."""

import contextlib

import pytest

from internals import style

BLANK = {
    "png": b"\x89PNG\r\n\x1a\n",
    "svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>',
    "pdf": b"%PDF-1.4\n",
}


@contextlib.contextmanager
def rendered(formats):
    """Figures are rendered in these formats only; the other files are blank."""
    write = style._write_one

    def write_or_leave_blank(made, path, kind):
        if kind in formats:
            return write(made, path, kind)
        path.write_bytes(BLANK[kind])
        return path

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "_write_one", write_or_leave_blank)
        yield
