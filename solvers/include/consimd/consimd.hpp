// The front door: from points, or correspondences, to a pose. All else is in headers of its own.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/point_ranges.hpp>
#include <consimd/poses/eigen_points.hpp>
#include <consimd/poses/point_pairs.hpp>
#include <consimd/solvers/advice.hpp>
#include <consimd/solvers/assumed_inliers.hpp>
#include <consimd/solvers/edge_information.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/stop_condition.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/threads.hpp>
#include <consimd/version.hpp>
