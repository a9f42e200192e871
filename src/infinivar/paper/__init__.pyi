from .displays import DisplayClaims, display_claims

__all__ = [
    "DisplayClaims",
    "display_claims",
]
