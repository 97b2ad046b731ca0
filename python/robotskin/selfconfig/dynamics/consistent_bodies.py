# SPDX-License-Identifier: Apache-2.0
"""Least squares over inertial parameters of which every link is a body that could exist: a convex problem.

A link's ten parameters π belong to a distribution of positive mass exactly if its pseudo-inertia P(π), 4 x 4 and linear
in π, is positive definite (Wensing, Kim and Slotine, IEEE RA-L 3(1), 2018, eq. 13 to 15).
"""

from __future__ import annotations

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from robotskin.errors import RobotskinError

Array = NDArray[np.float64]

PER_LINK = 10
"""m, m c (3), and I about the link's frame: xx, xy, yy, xz, yz, zz, as Pinocchio orders them."""
GUESS_MASS_KG = 2.0
GUESS_GYRATION_M = 0.1
"""A ball about the link's frame, to which whatever no torque tells is drawn."""


class DynamicsError(RobotskinError):
    """Torques from which no dynamic model follows."""


SETTLED = 1e-6
"""Twice what may be left to gain, in squares of a standard deviation."""
WEAKENING, WEAKENINGS = 10.0**0.5, 10
"""The divergence begins this often this much stronger than asked."""


def pseudo_inertia_basis() -> Array:
    """(10, 4, 4) with P(π) = Σ π_i basis_i: second moments Σ = tr(I)/2 − I, first moments m c, mass m."""
    basis = np.zeros((PER_LINK, 4, 4))
    basis[0, 3, 3] = 1.0
    for axis in range(3):
        basis[1 + axis, axis, 3] = basis[1 + axis, 3, axis] = 1.0
    for number, (row, column) in enumerate(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))):
        inertia = np.zeros((3, 3))
        inertia[row, column] = inertia[column, row] = 1.0
        basis[4 + number, :3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return basis


def is_consistent(parameters: Array) -> bool:
    """Whether ten parameters (10,) belong to a body of positive mass."""
    return bool(np.linalg.eigvalsh(np.einsum("i,iab->ab", parameters, pseudo_inertia_basis())).min() > 0)


def fit_bodies(matrix: Array, right: Array, links: int, pull: float = 0.01, passes: int = 2000) -> Array:
    """Minimise ½ |A x − b|² + pull · Σ D(P₀ ‖ P(π_l)), and the like for friction; x = (π of all links, friction).

    D = tr(P₀⁻¹ P) − log det(P₀⁻¹ P) − 4 is the entropic divergence from the guess P₀ (Lee, Wensing and Park, IEEE T-RO
    36(2), 2020, eq. 38). It is convex, tells nothing where torques do, and grows without bound where a body ceases to
    exist, so that damped Newton steps never leave the consistent ones.

    Args:
        matrix: (R, 10 links + F), whitened: one unit of A x − b is one standard deviation.
        right: (R,).
        links: their number; the F columns behind theirs are friction coefficients, kept positive.
        pull: weight of the divergence.
        passes: Newton steps at most.

    Raises:
        DynamicsError: no settled result.
    """
    basis = pseudo_inertia_basis()
    size = PER_LINK * links
    guess = pinocchio.Inertia.FromSphere(GUESS_MASS_KG, GUESS_GYRATION_M * np.sqrt(2.5)).toDynamicParameters()
    guess_inverse = np.linalg.inv(np.einsum("i,iab->ab", guess, basis))
    typical = np.maximum(1.0 / np.maximum(np.linalg.norm(matrix[:, size:], axis=0), 1e-9), 1e-9)
    unknown = np.concatenate([np.tile(guess, links), typical])
    hessian_of_squares = matrix.T @ matrix

    def value(x: Array, weight: float) -> float:
        bodies = np.einsum("li,iab->lab", x[:size].reshape(links, PER_LINK), basis)
        sign, logarithm = np.linalg.slogdet(bodies)
        if (np.linalg.eigvalsh(bodies)[:, 0] <= 0).any() or (sign <= 0).any() or (x[size:] <= 0).any():
            return np.inf
        friction = x[size:] / typical
        squares = 0.5 * float(((matrix @ x - right) ** 2).sum())
        divergence = np.einsum("ab,lba->", guess_inverse, bodies) - logarithm.sum()
        return squares + weight * float(divergence + (friction - np.log(friction)).sum())

    def newton_step(x: Array, weight: float) -> tuple[Array, float]:
        bodies = np.einsum("li,iab->lab", x[:size].reshape(links, PER_LINK), basis)
        gradient = matrix.T @ (matrix @ x - right)
        hessian = hessian_of_squares.copy()
        for link, inverse in enumerate(np.linalg.inv(bodies)):
            at = slice(PER_LINK * link, PER_LINK * (link + 1))
            turned = inverse @ basis
            gradient[at] += weight * np.einsum("ab,iba->i", guess_inverse - inverse, basis)
            hessian[at, at] += weight * np.einsum("iab,jba->ij", turned, turned)
        gradient[size:] += weight * (1.0 / typical - 1.0 / x[size:])
        hessian[np.arange(size, len(x)), np.arange(size, len(x))] += weight / x[size:] ** 2
        scale = 1.0 / np.sqrt(hessian.diagonal())
        step = -scale * cho_solve(
            cho_factor(hessian * scale * scale[:, None] + 1e-13 * np.eye(len(scale))), scale * gradient
        )
        return step, float(gradient @ step)

    taken = 0
    # Newton's steps are short where the divergence is weak and the start is far: so it is weakened by and by.
    for weight in pull * WEAKENING ** np.arange(WEAKENINGS, -1.0, -1.0):
        enough = SETTLED if weight == pull else max(SETTLED, 0.01 * weight)
        now = value(unknown, weight)
        while True:
            step, slope = newton_step(unknown, weight)
            # Half the squared Newton decrement bounds what is left to gain.
            if -slope < enough:
                break
            if taken == passes:
                raise DynamicsError(f"no settled dynamic model after {passes} steps; {-0.5 * slope:.1e} left to gain")
            taken += 1
            length = 1.0
            while length > 1e-12:
                then = value(unknown + length * step, weight)
                if then <= now + 0.1 * length * slope:
                    break
                length *= 0.5
            unknown, now = unknown + length * step, then
    return unknown
