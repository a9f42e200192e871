"""Sources of values as tables for the pages."""

from __future__ import annotations

from typing import Any

from infinivar import units
from infinivar.report import numbers
from infinivar.study.provenance import DEFAULT, Provenance


def provenance_tables(rows: tuple[Provenance, ...]) -> dict[str, list[dict[str, Any]]]:
    """Provenance by owner: each value as written, and in SI where that differs; defaults are omitted."""
    tables: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        si = units.show(row.value, row.unit) if row.unit else ""
        shown = numbers.quantity(row.value, row.unit, 4) if row.unit else ""
        default = bool(row.unit) and row.where == DEFAULT
        tables.setdefault(row.owner, []).append(
            {
                "field": row.field.replace(".", " · ").replace("_", " "),
                "written": shown if default else row.written,
                "si": "" if default or si == row.written else shown,
                "kind": row.kind,
                "where": row.where,
            }
        )
    return tables
