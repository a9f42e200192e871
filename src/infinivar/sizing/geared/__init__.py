"""Geared drives: every motor with every gearhead that fits it, at given output stages or at the best radius of a pulley."""

from infinivar.sizing.found import Design, GearedSizing, LimitCount
from infinivar.sizing.geared.search import size_geared

__all__ = ["Design", "GearedSizing", "LimitCount", "size_geared"]
