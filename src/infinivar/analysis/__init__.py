"""Analyses: functions of drive-trains that return frozen results; nothing here plots or prints."""
