"""How far two renders of a sphere, and two materials, are apart."""

import warnings

import numpy as np
from skimage.metrics import normalized_root_mse, peak_signal_noise_ratio, structural_similarity

# Of a render that is right to the last bit.
BEST_PSNR = 100.0


def images(truth: np.ndarray, answer: np.ndarray) -> np.ndarray:
    """PSNR in dB, NRMSE and DSSIM of each map, [N, 3], of renders [N, 3, 60, 120] in [0, 1]. All bins count, unseen ones too.

    PSNR: data_range 1. NRMSE: euclidean normalisation; not a number where the truth is black. DSSIM: (1 - SSIM) / 2 with
    data_range 1, channel_axis 0 and scikit-image's defaults: even 7 x 7 windows, sample covariance, mean over channels.
    """
    rows = []
    with warnings.catch_warnings(), np.errstate(divide="ignore", invalid="ignore"):
        for a, b in zip(truth, answer, strict=True):
            psnr = min(float(peak_signal_noise_ratio(a, b, data_range=1.0)), BEST_PSNR)
            nrmse = float(normalized_root_mse(a, b, normalization="euclidean"))
            ssim = float(structural_similarity(a, b, data_range=1.0, channel_axis=0))
            rows.append((psnr, nrmse if a.any() else np.nan, (1.0 - ssim) / 2.0))
    return np.array(rows)


def materials(truth: np.ndarray, answer: np.ndarray) -> np.ndarray:
    """Absolute errors of kd, ks and roughness of each material, [N, 3]: means over the channels."""
    error = np.abs(truth - answer)
    return np.stack([error[:, :3].mean(1), error[:, 3:6].mean(1), error[:, 6]], 1)
