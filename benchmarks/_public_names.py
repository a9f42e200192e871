"""Print every public name of infinivar and its public packages, with its signature and, of a class, its public members."""

import inspect
import pkgutil

import infinivar

ROOMS = ["", *(f".{one.name}" for one in pkgutil.iter_modules(infinivar.__path__) if one.name[0] != "_")]


def main():
    for room in ROOMS:
        module = __import__(f"infinivar{room}", fromlist=["_"])
        for name in sorted(getattr(module, "__all__", ())):
            print(f"infinivar{room}.{name}{described(getattr(module, name))}")


def described(value):
    if inspect.isclass(value):
        return signature(value) + "".join(f"\n    {name}{signature(member)}" for name, member in members(value))
    return signature(value)


def members(kind):
    for name, member in sorted(inspect.getmembers(kind)):
        if name[0] != "_" and not (isinstance(member, type(object.__init__)) or name == "mro"):
            yield name, member


def signature(value):
    if not callable(value):
        return ""
    try:
        return str(inspect.signature(value))
    except (TypeError, ValueError):
        return "(...)"


main()
