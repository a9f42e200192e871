"""
Creep laws against exact theory
===============================

Lateral force over slip force against creepage, scaled so that every law starts with slope 1 and the linear law slips at 1.
The markers show exact rolling-contact theory for three shapes of the contact patch.
"""

import matplotlib.pyplot as plt
import numpy as np

from infinivar.contact import creep, exact_tables

poisson, circle = 0.3, 1.0
xi = np.linspace(
    0.0, 5.0, 400
)  # creepage over the creepage at which the linear law slips; the functions expect k = xi/3

fig, ax = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
for law in ("linear", "vermeulen-johnson", "polach", "fastsim"):
    ax.plot(xi, creep.lateral_force(law, xi / 3, circle, poisson), label=law)
for curve, marker in zip(exact_tables.lateral_creep(), "+x1", strict=False):
    label = f"exact, a/b = {curve['a_over_b']:g}"
    ax.plot(3 * curve["scaled_creepage"], curve["force_ratio"], marker, color="black", ms=6, label=label)
ax.set(
    xlim=(0, 5),
    ylim=(0, 1.05),
    xlabel="creepage over slip creepage of the linear law [-]",
    ylabel=r"lateral force over $\mu P$ [-]",
)
ax.legend()
plt.show()

# %%
# At 60 % of the slip force the linear law predicts too little creep. The nonlinear laws come closer:

for law in ("linear", "vermeulen-johnson", "polach", "fastsim"):
    ratio = creep.lateral_creep(law, 0.6, circle, poisson) / creep.lateral_creep("linear", 0.6, circle, poisson)
    print(f"{law:18} {ratio:.2f} times the linear creepage")
