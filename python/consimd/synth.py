"""Synthetic registration problems with ground truth, and the errors against it.

    problem = consimd.synth.noise_study_problem(outlier_ratio=0.95, sigma=0.5)
    result = consimd.register(problem.source, problem.target, noise_bound=3 * problem.sigma)
    consimd.synth.rotation_error_deg(result.pose, problem.pose)
"""

from consimd._core import (
    Problem,
    family_problem,
    hard_problem,
    inlier_quality,
    noise_study_bound,
    noise_study_problem,
    oracle,
    problem_families,
    rmse_true_inliers,
    rotation_error_deg,
    scale_error,
    stand_in_problem,
    stand_ins,
    translation_error,
    write_problem,
)

__all__ = [
    "Problem",
    "family_problem",
    "hard_problem",
    "inlier_quality",
    "noise_study_bound",
    "noise_study_problem",
    "oracle",
    "problem_families",
    "rmse_true_inliers",
    "rotation_error_deg",
    "scale_error",
    "stand_in_problem",
    "stand_ins",
    "translation_error",
    "write_problem",
]
