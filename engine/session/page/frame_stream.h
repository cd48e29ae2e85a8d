// A recorded stream with one row per drawn frame. The session must outlive this object.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/session/session_file.h"

namespace typodont::session {

class FrameStream {
 public:
  FrameStream(const StreamSpec& spec, const StreamData& data) : spec_(&spec), data_(&data) {}

  std::size_t count() const { return data_->t.size(); }
  /// Values of a column, except NaN, multiplied by `scale` and sorted.
  std::vector<double> column(std::string_view name, double scale = 1) const {
    std::vector<double> values;
    for (std::size_t c = 0; c < spec_->columns.size() && c < data_->columns.size(); ++c) {
      if (spec_->columns[c].name != name) continue;
      for (const double v : data_->columns[c])
        if (std::isfinite(v)) values.push_back(v * scale);
    }
    std::sort(values.begin(), values.end());
    return values;
  }
  double sum(std::string_view name) const {
    const std::vector<double> values = column(name);
    return std::accumulate(values.begin(), values.end(), 0.0);
  }
  double mean(std::string_view name) const {
    const std::vector<double> values = column(name);
    return values.empty() ? 0.0 : sum(name) / static_cast<double>(values.size());
  }

 private:
  const StreamSpec* spec_;
  const StreamData* data_;
};

/// Empty if the session has no such stream or frames.
inline std::optional<FrameStream> frames_of(const SessionReader& session, std::string_view stream) {
  const auto& specs = session.header().streams;
  for (std::size_t i = 0; i < specs.size() && i < session.streams().size(); ++i)
    if (specs[i].name == stream && !session.streams()[i].t.empty()) return FrameStream(specs[i], session.streams()[i]);
  return std::nullopt;
}

}  // namespace typodont::session
