#include "outside/reply_text.hpp"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

constexpr std::size_t kShown = 60;         // characters of a foreign text in a message
constexpr double kLastRowRounding = 1e-6;  // as of a pose in a file

double number(std::string_view word) {
  const auto value = text::number_in<double>(word);
  if (!value) throw std::invalid_argument(fmt::format("{} is no number", shown_text(word)));
  if (!std::isfinite(*value)) throw std::invalid_argument(fmt::format("{} is not finite", shown_text(word)));
  return *value;
}

/// The time that the last two words tell, which are taken away.
std::optional<double> take_time(std::vector<std::string_view>& words) {
  if (words.size() < 2 || words[words.size() - 2] != "time") return std::nullopt;
  const double seconds = number(words.back());
  if (seconds < 0.0) throw std::invalid_argument(fmt::format("time {} is below 0", seconds));
  words.resize(words.size() - 2);
  return seconds;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c < ' ' || c > '~') c = '?';
  }
  return result;
}

std::string shown_text(std::string_view text) {
  return fmt::format("'{}{}'", printable(text.substr(0, kShown)), text.size() > kShown ? "..." : "");
}

ReplyText parse_reply(std::string_view line) {
  std::vector<std::string_view> words = text::split(line, " \t\r,");
  std::erase(words, "");
  ReplyText reply{.pose = std::nullopt, .seconds = take_time(words)};
  if (words.size() == 1 && words[0] == "none") return reply;
  if (words.size() != 12 && words.size() != 16) {
    throw std::invalid_argument(fmt::format("expected 12 or 16 numbers or none, got {} word{} {}", words.size(),
                                            words.size() == 1 ? "" : "s", shown_text(line)));
  }
  RigidTransform& pose = reply.pose.emplace(RigidTransform::Identity());
  for (std::size_t i = 0; i < words.size(); ++i) {
    const double value = number(words[i]);
    const auto row = static_cast<Eigen::Index>(i / 4), column = static_cast<Eigen::Index>(i % 4);
    if (row < 3) {
      pose.matrix()(row, column) = value;
    } else if (!(std::abs(value - (column == 3 ? 1.0 : 0.0)) <= kLastRowRounding)) {
      throw std::invalid_argument("the last row must be 0 0 0 1");
    }
  }
  return reply;
}

}  // namespace consimd::studies
