"""Export of a drive's plant to other programs: FMUs and plain C."""
