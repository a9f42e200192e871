"""The paper's claims: what it says (``claims.toml``), and one check a claim that a steady computation can make."""
