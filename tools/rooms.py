"""Print the code lines and files of each room of the package, and who asks which kind a machine is.

``python tools/rooms.py``. Code lines have a token that is neither a comment nor part of a docstring of a module, class or
function. The figures show whether ideas have merged; nothing is enforced, as denser code is not smaller code.
"""

from __future__ import annotations

import ast
import collections
import io
import tokenize
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "infinivar"
MACHINES, KINDS = "machines/", ("machines/kinds/", "machines/linkage.py")
"""Room of machines, and where its kinds are: outside it, a question which kind something is ties a file to all of them."""
SILENT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def main() -> None:
    """Print both tables."""
    trees = {file: ast.parse(file.read_text("utf-8")) for file in sorted(PACKAGE.rglob("*.py"))}
    lines, files = collections.Counter(), collections.Counter()
    for file, tree in trees.items():
        lines[room_of(file)] += code_lines(file.read_text("utf-8"), tree)
        files[room_of(file)] += 1
    for room, count in lines.most_common():
        print(f"{room:<14}{count:>7} code lines{files[room]:>5} files")
    print(f"{'together':<14}{sum(lines.values()):>7} code lines{sum(files.values()):>5} files")
    kinds = {name for file, tree in trees.items() if within(file, *KINDS) for name in classes(tree)}
    kinds -= {name for file, tree in trees.items() if not within(file, *KINDS) for name in classes(tree)}
    counts = {file: questions(tree, kinds) for file, tree in trees.items() if not within(file, MACHINES)}
    counts = {file: count for file, count in counts.items() if count}
    print(f"questions about kinds of machine outside their room: {sum(counts.values())} in {len(counts)} files")
    for file, count in sorted(counts.items(), key=lambda pair: -pair[1]):
        print(f"{count:>5}  {file.relative_to(PACKAGE)}")


def room_of(file: Path) -> str:
    """Folder at the top of the package, or "leaves" for its own files."""
    parts = file.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else "leaves"


def within(file: Path, *rooms: str) -> bool:
    """Whether a file is in one of some rooms."""
    return file.relative_to(PACKAGE).as_posix().startswith(rooms)


def classes(tree: ast.Module) -> list[str]:
    """Names of the classes of a module."""
    return [node.name for node in tree.body if isinstance(node, ast.ClassDef)]


def code_lines(text: str, tree: ast.AST) -> int:
    """Lines with code."""
    found: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in SILENT:
            found |= set(range(token.start[0], token.end[0] + 1))
    return len(found - docstring_lines(tree))


def docstring_lines(tree: ast.AST) -> set[int]:
    """Lines of the docstrings of modules, classes and functions."""
    named = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    first = (node.body[0] for node in ast.walk(tree) if isinstance(node, named) and ast.get_docstring(node) is not None)
    return {line for one in first for line in range(one.lineno, (one.end_lineno or one.lineno) + 1)}


def questions(tree: ast.AST, kinds: set[str]) -> int:
    """Calls of isinstance that name a kind."""
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call) and len(node.args) == 2)
    of_class = (call.args[1] for call in calls if isinstance(call.func, ast.Name) and call.func.id == "isinstance")
    return sum(any(isinstance(one, ast.Name) and one.id in kinds for one in ast.walk(named)) for named in of_class)


if __name__ == "__main__":
    main()
