"""A mesh that a file moved in its own space, by one translation for all of its instances (section 10.6 of the format).

The translation is nowhere stored: it is what the corners and the matrices have in common. Corners are rounded once from `right - origin`, and
each matrix holds its node's linear part and `M origin + t`, rounded once. Each number so bounds the origin; one origin must obey them all.

One number that is off alone, by more than a unit and a half in the last place, shows no translation: it is wrong.
"""

import numpy as np

from arithmetic import F64_SLACK, half_ulp

# Steps towards the origin that breaks no bound, and how far the last of them may stay off.
STEPS, NEARLY = 120, 1.02


def find(bodies, instances):
    """(origin f64[3], by how many bounds it is missed at most). No bound is kept (infinite) where one number alone is off without an origin.

    `bodies`: pairs of stored corners and right ones with their magnitudes, (f64[n, 3], f64[n, 3], f64[n, 3]).
    `instances`: (matrix of the file f64[3, 4], matrix of the node f64[4, 4], its magnitude f64[4, 4]).
    """
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    middles, corners_off, entries_off, clearly_off = [], [], [], []
    for stored, right, size in bodies:
        by, bound = right - stored, half_ulp(stored) + size * F64_SLACK
        corners_off.append((np.abs(by) / bound).max(axis=1))
        low, high = np.maximum(low, (by - bound).max(axis=0)), np.minimum(high, (by + bound).min(axis=0))
        middles.append(by)
    # Where corners leave no origin, some are wrong: most of them say where it is.
    middle = np.median(np.concatenate(middles), axis=0)
    inside = low <= high
    center = np.where(inside, (low + high) / 2, middle)
    width = np.where(inside, np.maximum((high - low) / 2, np.abs(center) * 2.0**-50), half_ulp(middle))

    rows, wanted = [np.diag(1 / width)], [np.zeros(3)]
    for stored, matrix, magnitude in instances:
        own = half_ulp(matrix[:3, 3]) + magnitude[:3, 3] * F64_SLACK
        entries_off.append(np.abs(stored[:, 3] - matrix[:3, 3]) / own)
        # What rounding of the corners moves them by anyway is nothing that one entry alone could show.
        clearly_off.append(np.abs(stored[:, 3] - matrix[:3, 3]) / (own + np.abs(matrix[:3, :3]) @ width))
        bound = half_ulp(stored[:, 3]) + magnitude[:3, 3] * F64_SLACK + magnitude[:3, :3] @ np.abs(center) * F64_SLACK
        # Beside the corners' own bounds, what is far narrower only costs digits.
        bound = np.maximum(bound, width.max() * 2.0**-32)
        rows.append(matrix[:3, :3] / bound[:, None])
        # About the middle of the corners' bounds, so that large numbers have gone.
        wanted.append((stored[:, 3] - matrix[:3, 3] - matrix[:3, :3] @ center) / bound)
    step, worst = least_maximum(np.concatenate(rows), np.concatenate(wanted))
    corners_off, entries_off, clearly_off = (np.concatenate(off) for off in (corners_off, entries_off, clearly_off))
    one_number = (corners_off > 1).sum() + (entries_off > 1).sum() == 1
    return center + step, np.inf if one_number and max(corners_off.max(), clearly_off.max()) > 3 else worst


def least_maximum(rows, wanted):
    """Lawson's method: the x whose largest |rows x - wanted| is the least. It ends where that is at most 1."""
    weights = np.full(len(rows), 1.0 / len(rows))
    best, least = np.zeros(3), np.abs(wanted).max()
    for _ in range(STEPS):
        if least <= 1:
            break
        root = np.sqrt(weights)[:, None]
        scaled = rows * root
        columns = np.maximum(np.abs(scaled).max(axis=0), 1e-300)
        x = np.linalg.lstsq(scaled / columns, wanted * root[:, 0], rcond=None)[0] / columns
        missed = np.abs(rows @ x - wanted)
        if missed.max() < least:
            best, least = x, missed.max()
        weights = weights * missed
        if not weights.sum() > 0:
            break
        weights = weights / weights.sum()
    return best, least
