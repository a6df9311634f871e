"""How fast the models are, against the same formulas in NumPy and against Mitsuba 3: `brdf bench models`."""
