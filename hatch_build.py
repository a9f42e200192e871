"""Build hook: the studies at the root of the repository come with the wheel."""

from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ShippedStudies(BuildHookInterface):
    """Add the studies to a wheel, but not to an editable install, which finds them in the repository."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Set the place of the studies in the package."""
        if version == "standard":
            build_data["force_include"]["studies"] = "infinivar/study/shipped_studies"
