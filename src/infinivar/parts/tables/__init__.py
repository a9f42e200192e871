"""Sets of parts as tables of columns: files, importers, checks and searches."""
