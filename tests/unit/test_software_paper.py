"""paper/paper.md: its numbers are those of the program, and its citations are in the bibliography."""

import re
from collections import Counter

import pytest

import infinivar as iv
from internals import HEAD_OF_MEASURED, rows_of_measured
from made import ROOT, made

TEXT = (ROOT / "paper/paper.md").read_text("utf-8")
VALIDATION = [
    [cell.strip() for cell in line.strip("| ").split("|")]
    for line in TEXT.split("| set | reading |")[1].split("\n\n")[0].splitlines()[2:]
]


@pytest.mark.parametrize("row", VALIDATION, ids=[row[0] for row in VALIDATION])
def test_residuals_are_those_of_the_report(row):
    name, reading, *stated = row
    report = iv.calibration.measured_report(name)
    cells = next(
        dict(zip(HEAD_OF_MEASURED, one, strict=True)) for one in rows_of_measured(report) if one[:2] == (name, reading)
    )
    assert stated == [cells["rms"], cells["left out: rms"]]


def test_claims_are_counted_as_reproduce_does():
    verdicts = Counter(claim.verdict for claim in made("reproduce").claims)
    said = re.search(
        r"The (\d+) claims.*?(\d+) hold, (\d+) hold by construction.*?, (\d+) do not, and (\d+) depend", TEXT, re.S
    )
    assert [int(one) for one in said.groups()] == [
        verdicts.total(),
        *(verdicts[word] for word in ("holds", "by construction", "does not hold", "undecidable")),
    ]


def test_what_is_cited_is_in_the_bibliography():
    known = (ROOT / "src/infinivar/references.bib").read_text("utf-8")
    cited = set(re.findall(r"@(\w+)", TEXT.split("---", 2)[2]))
    assert len(cited) > 5
    assert [key for key in cited if f"{{{key}," not in known] == []
