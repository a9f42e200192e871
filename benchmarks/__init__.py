"""Benchmarks: ratios to something everyone can run, measured side by side; ``python -m benchmarks`` runs them."""
