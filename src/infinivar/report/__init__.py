"""HTML reports from result objects: self-contained files, no network."""
