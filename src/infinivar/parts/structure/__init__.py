"""Bodies that carry the preload and the load: what they weigh, how far they give way, and what stresses them."""
