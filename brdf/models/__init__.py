"""The reflectance models, one file each; `brdf.registry` finds them by file name."""
