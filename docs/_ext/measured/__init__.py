"""Models of the program compared with measurements by others: the fits and figures of the page "Compared with measurements"."""
