"""What `brdf bench preview` measures: one part a file. The command and the page are in `fitter/cli`."""
