// A self-contained HTML page: no scripts, nothing from a network, readable on light and dark.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/report/table.h"

namespace isthmus::report {

// All text that is given is plain, from anywhere, and is escaped, but for the figures' SVG.
// Elements stand in the order in which they were added. Not thread safe.
class Page {
 public:
  Page(const std::string& title, const std::string& subtitle);

  void Section(const std::string& heading);
  void Paragraph(const std::string& text);
  // A row of boxes: a number or word, and what it is.
  void Tiles(const std::vector<std::pair<std::string, std::string>>& tiles);
  // A state of things, and what can be done about it.
  void Advice(const std::string& what, const std::string& todo);
  void Add(const Table& table);
  // `svg` as of InlineSvg. `on_white`: it holds pixels that need a white ground on dark pages too.
  void Figure(const std::string& svg, const std::string& caption, bool on_white = false);

  // The whole document.
  std::string Html() const;

 private:
  std::string title_, body_;
};

}  // namespace isthmus::report
