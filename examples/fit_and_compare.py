"""Fits three models to one measurement and prints which describes it best.

python examples/fit_and_compare.py [measurement]
"""

import pathlib
import sys

import fitter

SAMPLE = pathlib.Path(fitter.__file__).parent / "samples" / "copper_paint.csv"


def main(path: str = str(SAMPLE)) -> None:
    data = fitter.read(path)
    print(f"{data.source}: {len(data)} samples")
    for model in ("lambert", "lambert+beckmann", "lambert+ggx"):
        result = fitter.fit(model, data)
        print(f"{model:18} log error {result.errors['log_mae']:.4f}  {result.status}")
        for label, error in result.standard_errors().items():
            if label.endswith("alpha"):
                print(f"{'':18} {label} +/- {error:.2g}")


if __name__ == "__main__":
    main(*sys.argv[1:])
