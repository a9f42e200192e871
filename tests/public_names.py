"""What the package offers: names at the top, and names in its groups, such as `machines.ArmDrive`."""

from types import ModuleType

import infinivar as iv


def public_names():
    """Each public name with its value; formulas in modules of modules are reached through these."""
    found = {name: getattr(iv, name) for name in iv.__all__ if name != "__version__"}
    groups = {name: one for name, one in found.items() if isinstance(one, ModuleType)}
    return found | {
        f"{group}.{name}": getattr(one, name) for group, one in groups.items() for name in getattr(one, "__all__", ())
    }
