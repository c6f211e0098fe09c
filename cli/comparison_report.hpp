// How a comparison that is complete is shown.
#pragma once

#include <string>

#include <consimd/studies/paper_tables.hpp>

namespace consimd::cli {

/// Prints the tables, names the files of the comparison in `folder`, and draws its figures where there are any.
void print_comparison(const studies::ComparisonResults& results, const std::string& folder);

}  // namespace consimd::cli
