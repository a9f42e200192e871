"""What a load does over time: one family of motions and forces, the duty cycles and scenarios that use them."""
