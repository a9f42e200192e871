"""The explorer: a page in the browser on which a study can be changed and its maps move along."""
