"""Faulring, Colgate & Peshkin (2006) as a paper: its claims, its figures, and verdicts on them."""

from infinivar.report.saving import register

register("infinivar.paper.reproduce.Reproduction", "infinivar.paper.report")
