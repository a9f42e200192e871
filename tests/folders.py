"""What a command left in a folder."""


def results(folder):
    """Names of its files and folders, without the program's own notes."""
    return sorted(path.name for path in folder.iterdir() if path.name not in (".infinivar.lock", ".infinivar.json"))
