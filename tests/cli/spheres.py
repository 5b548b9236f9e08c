"""What a folder of `gonio synth spheres` should hold, worked out anew in float64. Prints the worst error; more than 1 % fails.

    python3 spheres.py FOLDER lobe|orthographic|perspective
"""

import sys
from pathlib import Path

import numpy as np

ETA, DISTANCE, MARGIN, ALLOWED = 1.5, 4.0, 0.03, 0.01

folder, kind = Path(sys.argv[1]), sys.argv[2]
maps, materials, lights = (np.load(folder / f"{name}.npy").astype(np.float64) for name in ("maps", "materials", "lights"))

theta = (np.arange(60) + 0.5) * np.pi / 60
phi = (np.arange(120) + 0.5) * 2 * np.pi / 120
theta, phi = np.meshgrid(theta, phi, indexing="ij")
bins = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def dot(a, b):
    return (a * b).sum(-1)


def unit(a):
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def fresnel(cos):
    """Unpolarised reflectance of a dielectric by Snell's and Fresnel's laws."""
    inside = np.sqrt(1 - (1 - cos**2) / ETA**2)
    s = ((cos - ETA * inside) / (cos + ETA * inside)) ** 2
    p = ((inside - ETA * cos) / (inside + ETA * cos)) ** 2
    return (s + p) / 2


def smith(alpha, cos):
    tan2 = 1 / cos**2 - 1
    return (np.sqrt(1 + alpha**2 * tan2) - 1) / 2


def radiance(material, light, normal, wo):
    """Linear RGB of every bin under a white light of irradiance pi, and which bins are in sight, lit, and not at an edge."""
    cos_i, cos_o = dot(normal, light), dot(normal, wo)
    seen = (cos_i > 0) & (cos_o > 0)
    clear = (cos_i > MARGIN) & (cos_o > MARGIN)
    cos_i, cos_o = np.where(seen, cos_i, 1), np.where(seen, cos_o, 1)
    alpha = max(material[6] ** 2, 1e-3)
    half = unit(light + wo)
    # Twice the angle's sine by the chord: 1 - cos^2 has no digits left in the lobe of a smooth surface.
    sin2 = np.linalg.norm(np.cross(normal, half), axis=-1) ** 2
    d = alpha**2 / (np.pi * (sin2 + dot(normal, half) ** 2 * alpha**2) ** 2)
    g = 1 / (1 + smith(alpha, cos_i) + smith(alpha, cos_o))
    specular = d * g * fresnel(dot(half, light)) / (4 * cos_i * cos_o)
    f = material[:3] / np.pi + specular[..., None] * material[3:6]
    return np.where(seen[..., None], np.pi * f * cos_i[..., None], 0), seen, clear


worst = compared = 0
for i, (found, material, light) in enumerate(zip(maps.transpose(0, 2, 3, 1), materials, unit(lights))):
    if kind == "lobe":
        normal, wo = np.broadcast_to([0.0, 0.0, 1.0], bins.shape), bins
    else:
        view = unit(np.load(folder / "views.npy").astype(np.float64)[i])
        normal, wo = bins, np.broadcast_to(view, bins.shape)
        if kind == "perspective":
            wo = unit(DISTANCE * view - bins)
    expected, seen, clear = radiance(material, light, normal, wo)
    assert not found[~seen & ~clear & (dot(normal, wo) < -1e-6)].any(), f"map {i}: a bin out of sight is filled"
    error = np.abs(found - expected)[clear] / np.maximum(expected[clear], 1e-3)
    worst, compared = max(worst, error.max(initial=0)), compared + clear.sum()
print(f"{len(maps)} maps, {compared} bins: worst error {100 * worst:.4f} %")
sys.exit(not (compared > 1000 * len(maps) / 2 and worst < ALLOWED))
