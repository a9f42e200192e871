"""Large studies in numbered chunks, on one machine or a cluster, that continue where they were stopped."""
