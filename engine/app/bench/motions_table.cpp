#include "engine/app/bench/motions_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace typodont {

std::string motions_table(const std::vector<BenchRow>& rows) {
  // names of the tools and of the motions, in the order in which the rows contain them
  std::vector<std::string> tools, motions;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  const auto note = [](std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const BenchRow& row : rows) {
    const std::string motion = row.name.substr(0, row.name.rfind(", "));
    note(tools, row.knob);
    note(motions, motion);
    std::string& cell = cells[{row.knob, motion}];
    cell += fmt::format("{}{:.0f}", cell.empty() ? "" : " / ", row.time_ns / 1000);
  }
  std::string head = "| tool |", rule = "|---|", lines;
  for (const std::string& motion : motions) head += fmt::format(" {} |", motion), rule += "---|";
  for (const std::string& tool : tools) {
    lines += fmt::format("| {} |", tool);
    for (const std::string& motion : motions) lines += fmt::format(" {} |", cells[{tool, motion}]);
    lines += "\n";
  }
  return head + "\n" + rule + "\n" + lines;
}

}  // namespace typodont
