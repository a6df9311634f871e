"""Renders one metal at four slopes side by side, under the built-in studio.

python examples/render_roughness.py
"""

import numpy as np

import brdf
import shaders


def main() -> None:
    pictures = []
    for alpha in (0.02, 0.1, 0.3, 0.7):
        metal = brdf.MODELS["ggx"](f0=[0.95, 0.64, 0.54], alpha=alpha)
        image = shaders.render(shaders.Scene((shaders.Part(metal),), width=128, height=128, samples=96))
        pictures.append(image.display)
    shaders.write_png("roughness.png", np.concatenate(pictures, axis=1))
    print(f"wrote roughness.png with {image.renderer}")


if __name__ == "__main__":
    main()
