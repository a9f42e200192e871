"""What a load does over time: courses, profiles, duty cycles, scenarios and recordings."""
