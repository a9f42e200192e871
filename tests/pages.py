"""Reports as a browser and a reader see them, and what must be true of every one."""

import re
from html.parser import HTMLParser


class Page(HTMLParser):
    """Text of a page, and the tables and pictures that are not in an element that scrolls."""

    VOID = ("meta", "link", "br", "img", "hr")

    def __init__(self, text):
        super().__init__()
        self.inside, self.loose, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag in ("table", "img") and "scroll" not in self.inside:
            self.loose.append(tag)
        if tag not in self.VOID:
            self.inside.append(dict(attributes).get("class") if tag == "div" else tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            self.inside.pop()

    def handle_data(self, data):
        if "style" not in self.inside:
            self.text += data


class Links(HTMLParser):
    """Addresses a browser would fetch, the tags that stay open, and the text."""

    VOID = ("meta", "link", "img", "br", "hr", "col", "input")

    def __init__(self, text):
        super().__init__()
        self.fetched, self.open, self.scripts, self.text = [], [], 0, ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.fetched += [given[key] for key in ("src", "srcset", "data", "poster") if key in given]
        self.fetched += [given["href"]] if tag == "link" else []
        self.scripts += tag == "script"
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def pages(folder):
    return {path.name: Page(path.read_text("utf-8")) for path in folder.glob("*.html")}


def needs_no_network(path):
    """Everything is in the page, and no script."""
    text = path.read_text("utf-8")
    found = Links(text)
    assert found.fetched
    assert all(address.startswith("data:") for address in found.fetched)
    assert found.scripts == 0
    assert found.open == []
    assert "@import" not in text
    assert "url(http" not in text


def reads_from_the_top(text):
    """The verdict comes before all else, notes are one list, and tables and figures can be reached, are named and print whole."""
    body = text.partition("<main>")[2]
    first = body.find('class="headline')
    assert first > 0
    assert all(not 0 <= body.find(f'class="{later}"') < first for later in ("note", "soft", "scroll"))
    assert body.count('class="note"') <= 1
    scrolling = re.findall(r'<div class="scroll"[^>]*>', body)
    assert scrolling or "<table" not in body
    assert all(re.search(r'tabindex="0" role="region" aria-label="[^"]+"', one) for one in scrolling)
    assert not re.search(r"<table[^>]*>\s*<tr>\s*<th", body)
    assert all('scope="col"' in one for one in re.findall(r"<thead>.*?</thead>", body, re.DOTALL))
    printed = text.partition("@media print")[2].partition("</style>")[0]
    for rule in (
        "thead { display: table-header-group; }",
        "h2, h3,",
        "break-after: avoid",
        "details-content",
        "overflow: visible",
    ):
        assert rule in printed, rule


def losses_have_their_colour(text, colour_of):
    """Every loss that a table names has a mark in the colour of figures and of the explorer."""
    marked = re.findall(r'<span class="loss" style="--of: (#\w+)">([^<]+)</span>', text)
    assert marked
    assert all(colour == colour_of(name) for colour, name in marked)


def is_set_well(folder):
    """No padded exponents, no line that ends before a unit, percent signs that stand apart; wide parts scroll inside."""
    for path in folder.glob("*.html"):
        text = path.read_text("utf-8")
        reads_from_the_top(text)
        found = Page(text)
        padded = re.findall(r".{20}\de[+-]?0\d.{10}|.{20}\de\+\d.{10}", found.text)
        assert not padded, (path, padded)
        assert not re.findall(r".{9}\d (?:%|°C|J|W|N|mm|mN m|m/s|s|g)(?!\w).{9}", found.text), path
        assert not re.findall(r".{9}\d%.{9}", found.text), path
        assert " × " not in found.text.replace("0.88 × 0.87", ""), path
        assert "\N{NO-BREAK SPACE}" not in text.partition("<body>")[0], path
        assert found.text.strip()
        assert found.loose == []
        assert found.inside == []
