"""Pins of the shipped study against ourselves: a change here is a change users will see."""

import pytest

# name: coverage, peak efficiency in the region, mean loss [W], tightest limit, margin
EXPECTED = {
    "cobotic": (1.0, 0.69157, 4.565, "VOLTAGE", 1.08234),
    "cobotic-b": (1.0, 0.73777, 2.440, "VOLTAGE", 1.08872),
    "motor1-gear1": (0.61993, 0.73171, 2.568, "VOLTAGE", 0.40053),
    "motor1-gear2": (0.60513, 0.68388, 3.303, "THERMAL", 0.61839),
    "motor1-gear3": (0.53653, 0.62520, 4.227, "THERMAL", 0.39357),
    "motor2-gear4": (1.0, 0.64792, 5.142, "THERMAL", 1.01021),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_result(comparison, name):
    coverage, efficiency, loss, limit, margin = EXPECTED[name]
    result = comparison.results[name]
    assert result.coverage == pytest.approx(coverage, abs=2e-4)
    assert result.peak_efficiency_in_region == pytest.approx(efficiency, abs=1e-5)
    assert result.mean_loss == pytest.approx(loss, abs=2e-3)
    assert result.tightest.limit.name == limit
    assert result.tightest.value == pytest.approx(margin, abs=1e-5)
