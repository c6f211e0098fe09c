// How a comparison that is complete is shown.
#pragma once

#include <string>
#include <vector>

#include <consimd/studies/text_table.hpp>

namespace consimd::cli {

/// Prints the tables, names the files of the comparison in `folder`, and draws its figures where there are any.
void print_comparison(const std::vector<studies::TextTable>& tables, const std::string& folder);

}  // namespace consimd::cli
