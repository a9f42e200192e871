"""How results depend on parameters: derivatives, sensitivity, samples within tolerances, verdicts over them."""
