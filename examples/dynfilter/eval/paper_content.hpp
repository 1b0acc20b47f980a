// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "eval/comparison.hpp"
#include "eval/provenance.hpp"

// What a table for a paper says, whatever its format.
namespace dynfilter::eval::paper {

/// Below this, a difference is called more than noise.
constexpr double kSignificance = 0.05;

enum class Better { Neither, Less, More };

struct Column {
  const char* key;  ///< in CSV
  const char* group;
  const char* name;
  const char* unit;
  int digits;
  Better better;
  bool of_several;  ///< says nothing about a single run
  double (*value)(const ComparedRow&);
};

/// Figures only: the names of sequence and pipeline stand before them.
const std::vector<Column>& columns();

struct Cell {
  std::string text;
  bool best = false;
};

struct Row {
  std::size_t index;  ///< in the comparison
  std::string pipeline;
  std::vector<Cell> cells;  ///< one per shown column
};

/// The rows of a scene.
struct Block {
  std::string title;
  std::vector<Row> rows;
};

struct Content {
  std::vector<Column> columns;  ///< those with any figure
  std::vector<Block> blocks;
  std::string caption;
  std::vector<std::string> notes;
};

Content content_of(const Comparison& comparison, const Provenance& provenance);

}  // namespace dynfilter::eval::paper
