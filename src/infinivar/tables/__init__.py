"""Tables in files: from bytes to columns in SI, with faults by line and cell."""
