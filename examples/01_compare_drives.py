"""
Compare the drives of a study
=============================

A study states a requirement (force, speed and power) and the drives that should meet it. Which drives cover the required
region, what limits the others, and how much power does each lose?
"""

import matplotlib.pyplot as plt

import infinivar as iv

study = iv.load_study("hand_controller")
result = iv.compare(study)

for drive in result.results.values():
    limit, margin = drive.tightest.limit.words, drive.tightest.value
    print(f"{drive.title:38} covers {drive.coverage:4.0%}, tightest limit: {limit} ({margin:.2f})")

# %%
# The bars show the share of the required region that each drive covers, and its mean loss there. The loss of a drive that
# does not cover the region is averaged only over the part it reaches. It is not comparable and drawn pale.

drives = list(result.results.values())
fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.2), sharey=True, layout="constrained")
for place, drive in enumerate(drives):
    shade = 1.0 if drive.covers else 0.35
    left.barh(place, 100 * drive.coverage, color="C0", alpha=shade)
    right.barh(place, drive.mean_loss, color="C1", alpha=shade)
left.set_yticks(range(len(drives)), [drive.title for drive in drives])
left.invert_yaxis()
left.set_xlabel("covered share of the required region [%]")
right.set_xlabel("mean loss in the required region [W]")
plt.show()
