#include "engine/app/bench/row_origin.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engine/base/split.h"

namespace typodont {

namespace {

constexpr std::string_view kOthers = "all other parts: ";

}  // namespace

std::vector<RowOrigin> origins_of(std::string_view text) {
  std::vector<RowOrigin> origins;
  for (std::string_view segment : split(text, "; ")) {
    if (segment.starts_with(kOthers)) segment.remove_prefix(kOthers.size());
    RowOrigin origin{std::string(segment), {}};
    const std::size_t open = segment.rfind(" (");
    if (segment.ends_with(')') && open != std::string_view::npos) {
      origin.made = segment.substr(0, open);
      for (const std::string_view name : split(segment.substr(open + 2, segment.size() - open - 3), ", "))
        origin.names.emplace_back(name);
    }
    origins.push_back(std::move(origin));
  }
  return origins;
}

std::string text_of(const std::vector<RowOrigin>& origins) {
  std::string text;
  for (const RowOrigin& origin : origins) {
    const bool first = text.empty();
    if (!first) text += "; ";
    if (!origin.names.empty())
      text += fmt::format("{} ({})", origin.made, fmt::join(origin.names, ", "));
    else
      text += fmt::format("{}{}", first ? "" : kOthers, origin.made);
  }
  return text;
}

std::vector<RowOrigin> joined(const std::vector<RowOrigin>& origins) {
  std::vector<RowOrigin> all;
  std::vector<std::string> known;
  for (const RowOrigin& origin : origins) {
    const bool others = origin.names.empty();
    auto same = std::ranges::find(all, origin.made, &RowOrigin::made);
    if (others) {
      if (same != all.end()) all.erase(same);
      all.push_back(origin);
      break;
    }
    for (const std::string& name : origin.names) {
      if (std::ranges::find(known, name) != known.end()) continue;
      known.push_back(name);
      same = std::ranges::find(all, origin.made, &RowOrigin::made);
      if (same == all.end()) same = all.insert(all.end(), {origin.made, {}});
      same->names.push_back(name);
    }
  }
  return all;
}

}  // namespace typodont
