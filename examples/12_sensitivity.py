"""
Which parameters matter
=======================

`sensitivity` ranks the parameters of a drive by their effect on one outcome, here the loss at one operating point. It uses
exact derivatives, and also evaluates each parameter at both ends of its range.
"""

import matplotlib.pyplot as plt

import infinivar as iv

study = iv.load_study("hand_controller")
found = iv.sensitivity(study, "cobotic", "loss", speed=0.3, force=25.0)
print(f"loss at 0.3 m/s and 25 N: {found.value:.2f} W")
for row in found.influences[:5]:
    print(f"+1 % in {row.words} changes the loss by {row.elasticity:+.2f} %")

# %%
# Tornado chart of the ten most influential parameters, each varied alone over its range:

rows = found.influences[:10][::-1]
fig, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
for place, row in enumerate(rows):
    for end, colour in ((row.at_low, "C0"), (row.at_high, "C1")):
        ax.barh(place, end - found.value, left=found.value, color=colour, height=0.7)
ax.axvline(found.value, color="black", lw=0.8)
ax.set_yticks(range(len(rows)), [row.words for row in rows])
ax.set_xlabel("loss [W]")
ax.legend(ax.patches[:2], ["parameter at its low end", "at its high end"], loc="lower right")
plt.show()
