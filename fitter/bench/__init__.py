"""How fast the models and the fits are, against named peers: `brdf bench models` and `brdf bench fit`."""
