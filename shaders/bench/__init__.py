"""What `brdf bench preview` measures: one part of the benchmark a file. The command and the page are in `fitter/cli`."""
