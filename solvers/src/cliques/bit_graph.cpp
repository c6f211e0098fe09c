#include <consimd/solvers/bit_graph.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "bits/bit_rows.hpp"

namespace consimd {
namespace {

void require_vertex(std::size_t vertex, std::size_t size) {
  if (vertex < size) return;
  throw std::out_of_range("vertex is " + std::to_string(vertex) + ", expected one below " + std::to_string(size));
}

}  // namespace

void BitGraph::assign_empty(std::size_t size) {
  size_ = size;
  words_ = detail::words_for(size);
  bits_.assign(size_ * words_, 0);
}

void BitGraph::assign_subgraph(const GraphView& parent, std::span<const std::uint32_t> vertices) {
  assign_empty(vertices.size());
  chosen_.assign(parent.words(), 0);
  positions_.resize(parent.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    require_vertex(vertices[i], parent.size());
    detail::set_bit(chosen_, vertices[i]);
    positions_[vertices[i]] = i;
  }
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    const std::span<const std::uint64_t> from = parent.row(vertices[i]);
    const std::span<std::uint64_t> to = row(i);
    for (std::size_t w = 0; w < chosen_.size(); ++w) {
      detail::for_each_in_word(from[w] & chosen_[w], w, [&](std::uint32_t j) { detail::set_bit(to, positions_[j]); });
    }
    detail::clear_bit(to, i);
  }
}

void BitGraph::connect(std::size_t i, std::size_t j) {
  require_vertex(i, size_);
  require_vertex(j, size_);
  if (i == j) throw std::invalid_argument("vertex " + std::to_string(i) + " is connected to itself");
  detail::set_bit(row(i), j);
  detail::set_bit(row(j), i);
}

CoreNumbers core_numbers(const GraphView& graph) {
  const std::size_t size = graph.size();
  CoreNumbers result;
  std::vector<std::uint32_t>& degree = result.core;
  std::vector<std::uint32_t>& order = result.order;
  degree.resize(size);
  order.resize(size);
  // Vertices in buckets of equal degree, one after the other; first[d] is where bucket d begins.
  std::vector<std::uint32_t> first(size + 1, 0);
  for (std::size_t v = 0; v < size; ++v) {
    degree[v] = popcount(graph.row(v)) - (graph.adjacent(v, v) ? 1U : 0U);
    ++first[degree[v] + 1];
  }
  for (std::size_t d = 0; d < size; ++d) first[d + 1] += first[d];
  std::vector<std::uint32_t> position(size);
  std::vector<std::uint32_t> next(first);
  for (std::uint32_t v = 0; v < size; ++v) {
    position[v] = next[degree[v]]++;
    order[position[v]] = v;
  }
  std::vector<std::uint64_t> left(graph.words(), ~std::uint64_t{0});  // not yet peeled
  for (std::uint32_t p = 0; p < size; ++p) {
    const std::uint32_t peeled = order[p];
    detail::clear_bit(left, peeled);
    const auto lower = [&](std::uint32_t u) {
      if (degree[u] <= degree[peeled]) return;  // as tightly bound
      // u becomes the last of the bucket below: it changes places with the first of its own.
      const std::uint32_t start = first[degree[u]];
      const std::uint32_t other = order[start];
      std::swap(order[start], order[position[u]]);
      std::swap(position[u], position[other]);
      first[degree[u]] = start + 1;
      --degree[u];
    };
    const std::span<const std::uint64_t> row = graph.row(peeled);
    for (std::size_t w = 0; w < row.size(); ++w) detail::for_each_in_word(row[w] & left[w], w, lower);
  }
  return result;
}

std::vector<std::uint32_t> maximum_core(const GraphView& graph) {
  const CoreNumbers numbers = core_numbers(graph);
  std::vector<std::uint32_t> vertices;
  if (numbers.core.empty()) return vertices;
  const std::uint32_t largest = *std::ranges::max_element(numbers.core);
  for (std::uint32_t v = 0; v < numbers.core.size(); ++v) {
    if (numbers.core[v] == largest) vertices.push_back(v);
  }
  return vertices;
}

}  // namespace consimd
