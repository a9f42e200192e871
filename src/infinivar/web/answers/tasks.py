"""Machines in the tasks and on the paths of a study: what `compare` says of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from infinivar.analysis.machines import MachineComparison
from infinivar.limits import words_of
from infinivar.web.answers.answer import Answer
from infinivar.web.answers.document import study_of
from infinivar.web.answers.glance import compared


def tasks(payload: Mapping[str, Any]) -> Answer:
    """Feasibility, powers and the tightest limit of every machine in every task and path."""
    study = study_of(payload)
    if not (study.tasks or study.paths):
        reason = (
            "the study has sessions at a user's handle: infinivar session runs them"
            if study.sessions
            else "the study has no tasks or paths of machines: its drives have maps"
        )
        return Answer(header={"machines": {}, "reason": reason})
    found = compared(payload)
    assert isinstance(found, MachineComparison)
    machines = {}
    for name, result in found.results.items():
        rows = []
        for key, one in result.found.items():
            group, _, task = key.partition(".")
            rows.append(
                {
                    "key": key,
                    "group": group,
                    "name": task,
                    "title": one.title,
                    "feasible": one.feasible,
                    "power": one.mean_power,
                    "steady_power": one.steady_power,
                    "steering_power": one.steering_power,
                    "servos": "; ".join(words for words in (one.servo_words, one.battery_words) if words),
                    "losses": one.losses,
                    "limit": one.demand[0].name,
                    "words": words_of(one.demand),
                    "margin": one.margin,
                    "tightest": one.tightest_words,
                    "audit_residual": one.audit_residual,
                }
            )
        machines[name] = {
            "title": result.title,
            "feasible": result.feasible,
            "verdict": result.verdict,
            "motor_mass": result.motor_mass,
            "mean_power": result.mean_power,
            "steady_power": result.steady_power,
            "not_counted": dict(result.lacking),
            "tasks": rows,
        }
    return Answer(header={"machines": machines, "verdict": found.verdict, "feasible": found.feasible, "reason": ""})
