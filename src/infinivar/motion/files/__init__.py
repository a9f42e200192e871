"""Recordings from files of loggers, gait laboratories and other programs, as one table of columns in SI."""
