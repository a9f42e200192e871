"""The benches by the name that a measured set gives."""

from infinivar.calibration.measured.actuator import BACKDRIVE, STEADY
from infinivar.calibration.measured.creeping import CREEPING
from infinivar.calibration.measured.friction import NO_LOAD, SCREW, STRAIN_WAVE
from infinivar.calibration.measured.heating import HEATING

BENCHES = {law.name: law for law in (NO_LOAD, SCREW, STRAIN_WAVE, STEADY, BACKDRIVE, HEATING, CREEPING)}
"""Laws of benches by name."""
