"""Break-even of a cobotic and a conventional display over holding force, number of axes and share of time in contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check_instance
from infinivar.analysis.sessions.display_pair import DisplayPair
from infinivar.analysis.sessions.handle_session import HandleSession, cobotic_part, geared_part
from infinivar.analysis.shared_motor import SharedMotor, share_motor


def display_break_even(
    pair: DisplayPair,
    session: HandleSession | None = None,
    *,
    force: Array,
    axes: Sequence[int] = (1, 2, 3, 4, 5, 6),
    duty: Array,
) -> SharedMotor:
    """Mean powers of both displays where a force is held for a share of the time, with free motion and idling in the rest.

    Parameters
    ----------
    pair : DisplayPair
    session : HandleSession     Its free motion and idling share the rest as in the session; one run-up in each round. Its other
        parts do not matter.
    force : (F,) float          Held by each axis, rising, >= 0. [N]
    axes : (N,) int             Numbers of axes.
    duty : float or (D,) float  Shares of time in which the force is held, 0 to 1.

    Returns
    -------
    SharedMotor   Its legs are the axes.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: `share_motor`, with the powers of free motion from `cobotic_part` and `geared_part`.
    """
    session = HandleSession() if session is None else session
    check_instance("pair", pair, DisplayPair)
    check_instance("session", session, HandleSession)
    shares = session.shares
    rest = shares["free"] + shares["idle"]
    free = shares["free"] / rest if rest > 0.0 else 0.0
    powers = np.zeros(np.size(np.asarray(axes))), 0.0
    if free > 0.0:
        mass, share = pair.handle_mass, pair.compensation
        powers = (
            np.array(
                [cobotic_part(pair.cobotic, session, "free", axes=int(one), handle_mass=mass).supply for one in axes]
            ),
            geared_part(pair.conventional, session, "free", axes=1, handle_mass=mass, compensation=share).supply,
        )
    return share_motor(
        pair.cobotic,
        pair.conventional,
        force=force,
        legs=axes,
        duty=duty,
        period=session.round_time,
        run_up_time=pair.run_up_time,
        held_by_friction=pair.friction_helps,
        free_share=free,
        free_power=powers,
    )
