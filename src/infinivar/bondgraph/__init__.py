"""Bond graphs: one graph of a machine, from which its drawing, equations, simulation and energy audit all come."""
