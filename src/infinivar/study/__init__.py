"""Study files: schema, loading, and the shipped parameter sets with the provenance of every number."""
