"""How far the designs of a search withstand the spread of their parts: samples common to all designs."""
