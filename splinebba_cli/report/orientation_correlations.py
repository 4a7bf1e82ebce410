"""Correlations of the orientation unknowns from dispersion.npz: inside images, and between them where it is full."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.full_dispersion import EOP
from splinebba_cli.report.result_data import ResultData

PARAMETERS = ("ω", "φ", "κ", "X₀", "Y₀", "Z₀")


@dataclass(frozen=True)
class OrientationCorrelations:
    """Correlations r inside every image; NaN where an unknown is held fixed."""

    images: tuple[str, ...]
    inside: FloatArray  # (m, 6, 6)
    whole: FloatArray | None  # (6 m, 6 m), None where the dispersion is not full

    @classmethod
    def of(cls, data: ResultData) -> OrientationCorrelations | None:
        """From the dispersion of a result; None where there is none."""
        arrays = data.dispersion
        if "image_dispersion" not in arrays or not len(arrays["image_ids"]):
            return None
        images = tuple(str(name) for name in arrays["image_ids"])
        whole = None
        if "matrix" in arrays:
            row = {str(name): k for k, name in enumerate(arrays["names"])}
            wanted = [row.get(f"image {image} {name}") for image in images for name in EOP]
            whole = _correlation(_picked(np.asarray(arrays["matrix"]), wanted))
        return cls(images, _correlation(np.asarray(arrays["image_dispersion"])), whole)

    def largest(self) -> FloatArray:
        """Largest |r| of two different unknowns inside every image, (m,); 0 where there are no two."""
        above = np.triu(np.ones((6, 6), dtype=bool), 1)
        size: FloatArray = np.nan_to_num(np.abs(self.inside[:, above])).max(axis=1)
        return size

    def strongest_pair(self, image: int) -> tuple[str, str, float] | None:
        """The two unknowns of an image that are correlated most, and their r."""
        r = np.triu(np.nan_to_num(self.inside[image]), 1)
        i, j = np.unravel_index(int(np.abs(r).argmax()), (6, 6))
        return (PARAMETERS[i], PARAMETERS[j], float(r[i, j])) if r[i, j] else None


def _correlation(covariance: FloatArray) -> FloatArray:
    sigma = np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), 0.0))
    product = sigma[..., :, None] * sigma[..., None, :]
    found = np.full(covariance.shape, np.nan)
    np.divide(covariance, product, out=found, where=product > 0.0)
    return found


def _picked(matrix: FloatArray, rows: list[int | None]) -> FloatArray:
    """Rows and columns of a matrix; 0 for those that it does not have."""
    known = [(k, row) for k, row in enumerate(rows) if row is not None]
    found = np.zeros((len(rows), len(rows)))
    if known:
        here, there = (np.array(each) for each in zip(*known, strict=True))
        found[np.ix_(here, here)] = matrix[np.ix_(there, there)]
    return found
