"""Weight functions of robust estimation, of standardised residuals u (M-estimators as reweighted least squares).

    Huber    p = 1 up to c, c / |u| beyond                            c = 1.345     (Huber 1964)
    Cauchy   p = 1 / (1 + (u / c)^2)                                  c = 2.3849
    Tukey    p = (1 - (u / c)^2)^2 up to c, 0 beyond (biweight)       c = 4.6851    (Beaton and Tukey 1974)
    Danish   p = 1 up to c, exp(1 - (u / c)^2) beyond                 c = 3         (Krarup, Juhl and Kubik 1980)

The constants of the first three give 95 % of the efficiency of least squares where all errors are normal (Holland and
Welsch 1977).  The Danish method is published with several exponentials; this one is continuous at c.  Huber's estimate
is unique; the other three have several minima and begin from a start that should be near.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import ndtri_exp

from splinebba_cli.core.network import FloatArray

HUBER, CAUCHY, TUKEY, DANISH = 1.345, 2.3849, 4.6851, 3.0


def huber(u: FloatArray) -> FloatArray:
    """Weights of Huber's function."""
    return np.asarray(HUBER / np.maximum(np.abs(u), HUBER))


def cauchy(u: FloatArray) -> FloatArray:
    """Weights of Cauchy's function."""
    return np.asarray(1.0 / (1.0 + (u / CAUCHY) ** 2))


def tukey(u: FloatArray) -> FloatArray:
    """Weights of Tukey's biweight."""
    return np.asarray(np.maximum(1.0 - (u / TUKEY) ** 2, 0.0) ** 2)


def danish(u: FloatArray) -> FloatArray:
    """Weights of the Danish method."""
    return np.asarray(np.exp(np.minimum(1.0 - (u / DANISH) ** 2, 0.0)))


WEIGHT_FUNCTIONS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "huber": huber,
    "cauchy": cauchy,
    "tukey": tukey,
    "danish": danish,
}


def radial(standardized: FloatArray) -> FloatArray:
    """One value for the two coordinates of an image point, (n,): as improbable for one normal residual as

        rho^2 = u_x^2 + u_y^2    is for two:    P(|N(0, 1)| > u) = exp(-rho^2 / 2)

    so that constants of one residual hold, and both coordinates get one weight whatever the axes of the photo are.
    A coordinate that is not testable (NaN) counts as 0.
    """
    square = np.sum(np.nan_to_num(standardized) ** 2, axis=1)
    return np.asarray(np.maximum(-ndtri_exp(-0.5 * square - np.log(2.0)), 0.0))
