"""Registration of 3D point correspondences: vectorised consensus kernels and the solvers built on them.

    result = consimd.register(source, target, noise_bound=0.2)
    if result.has_pose:
        moved = source @ result.pose[:3, :3].T + result.pose[:3, 3]

`source` and `target` are (N, 3) arrays; row k of one is putatively the same point as row k of the other. Modules:
`consimd.kernels`, the building blocks on arrays; `consimd.features`, from clouds to correspondences;
`consimd.synth`, problems with a known pose. `consimd.register_clouds` takes two scans as they are. `consimd.sweep` runs
the noise study, `consimd.compare` solvers on files and synthetic data. Results have the same bits on any number of threads
and any instruction set, and those of the C++ library.
"""

from consimd import features, kernels, synth
from consimd._core import Correspondences, __version__, wilson_interval
from consimd._compare import CompareResult, ComparisonTable, compare
from consimd._plots import plot_sweep
from consimd._register import (
    NoiseBoundEstimate,
    OptionDescription,
    Registration,
    RunnerUp,
    Stage,
    Status,
    describe_options,
    estimate_noise_bound,
    log10_false_poses,
    register,
    solver_options,
    solvers,
)
from consimd._register_clouds import CloudRegistration, register_clouds
from consimd._sweep import SweepResult, sweep
from consimd._tables import table_columns
from consimd._view import view

__all__ = [
    "CloudRegistration",
    "CompareResult",
    "ComparisonTable",
    "Correspondences",
    "NoiseBoundEstimate",
    "OptionDescription",
    "Registration",
    "RunnerUp",
    "Stage",
    "Status",
    "SweepResult",
    "__version__",
    "compare",
    "describe_options",
    "estimate_noise_bound",
    "features",
    "kernels",
    "log10_false_poses",
    "plot_sweep",
    "register",
    "register_clouds",
    "solver_options",
    "solvers",
    "sweep",
    "synth",
    "table_columns",
    "view",
    "wilson_interval",
]
