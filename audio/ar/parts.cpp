#include "audio/ar/parts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "audio/ar/spectrum.h"

namespace typodont::audio {

namespace {

constexpr double kFrame = 0.05;  // s, length of a frame of the recording
// Frames this much quieter than loud frames are inaudible, dB.
constexpr double kAudible = 25;
// dB, largest change of the level within kEvenOver frames that still counts as a constant level
constexpr double kEvenWithin = 1.5;
constexpr std::ptrdiff_t kEvenOver = 6;
constexpr double kUnderLoad = 2.5;     // dB, rise of the level above the idle level that counts as load
constexpr double kShortestPart = 0.2;  // s, shorter parts of a recording are merged with a neighbour
constexpr std::array<std::string_view, 4> kNames = {"run-up", "idle", "load", "run-down"};

/// Level that separates quiet from loud frames (Otsu 1979), dB; nullopt if their levels do not differ.
std::optional<double> dividing_level(std::vector<double> levels, std::size_t fewest) {
  std::sort(levels.begin(), levels.end());
  std::vector<double> sums(levels.size() + 1, 0.0);
  std::partial_sum(levels.begin(), levels.end(), sums.begin() + 1);
  double best = 0;
  std::optional<double> at;
  for (std::size_t i = fewest; i + fewest <= levels.size(); ++i) {
    const auto low = static_cast<double>(i), high = static_cast<double>(levels.size() - i);
    const double difference = (sums.back() - sums[i]) / high - sums[i] / low;
    const double between = low * high * difference * difference;
    if (difference < kUnderLoad || between <= best) continue;
    best = between;
    at = (levels[i - 1] + levels[i]) / 2;
  }
  return at;
}

}  // namespace

std::string_view name_of(DrillPart part) noexcept {
  return kNames[static_cast<std::size_t>(part)];
}

std::optional<DrillPart> drill_part_named(std::string_view name) noexcept {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<DrillPart>(found - kNames.begin());
}

std::vector<SoundPart> parts_of(std::span<const double> x, double rate) {
  const auto frame = static_cast<std::size_t>(kFrame * rate);
  const std::vector<double> levels = frame_levels(x, frame);
  const auto count = static_cast<std::ptrdiff_t>(levels.size());
  if (count < 10) return {};
  std::vector<double> sorted = levels;
  std::sort(sorted.begin(), sorted.end());
  const double loud = sorted[static_cast<std::size_t>(0.9 * static_cast<double>(count - 1))];
  const auto level_at = [&](std::ptrdiff_t i) {
    return levels[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, count - 1))];
  };
  const auto audible = [&](std::ptrdiff_t i) { return level_at(i) > loud - kAudible; };
  const auto even = [&](std::ptrdiff_t i) {
    const double before = (level_at(i - kEvenOver / 2) + level_at(i - 1)) / 2;
    const double after = (level_at(i + kEvenOver / 2) + level_at(i + 1)) / 2;
    return level_at(i) > loud - kAudible / 2 && std::abs(after - before) < kEvenWithin;
  };
  std::ptrdiff_t heard_from = 0, heard_to = count, from = 0, to = count;
  while (heard_from < count && !audible(heard_from)) ++heard_from;
  while (heard_to > heard_from && !audible(heard_to - 1)) --heard_to;
  from = heard_from, to = heard_to;
  while (from < to && !even(from)) ++from;
  while (to > from && !even(to - 1)) --to;
  if (from == to) return {};

  // From the first to the last frame with a constant level, the drill idles or works under load. Parts shorter than
  // kShortestPart are joined to a neighbouring part.
  const auto shortest = static_cast<std::ptrdiff_t>(std::lround(kShortestPart / kFrame));
  const auto limit = dividing_level({levels.begin() + from, levels.begin() + to}, static_cast<std::size_t>(shortest));
  std::vector<DrillPart> parts(static_cast<std::size_t>(count), DrillPart::kIdle);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    DrillPart& part = parts[static_cast<std::size_t>(i)];
    if (i < from) part = DrillPart::kRunUp;
    if (i >= to) part = DrillPart::kRunDown;
    if (i >= from && i < to && limit && level_at(i) > *limit) part = DrillPart::kLoad;
  }
  for (std::ptrdiff_t i = from; i < to;) {
    std::ptrdiff_t end = i;
    while (end < to && parts[static_cast<std::size_t>(end)] == parts[static_cast<std::size_t>(i)]) ++end;
    if (end - i < shortest && (i > from || end < to)) {
      const DrillPart neighbour = parts[static_cast<std::size_t>(i > from ? i - 1 : end)];
      std::fill(parts.begin() + i, parts.begin() + end, neighbour);
    }
    i = end;
  }
  std::vector<SoundPart> result;
  for (std::ptrdiff_t i = heard_from; i < heard_to;) {
    std::ptrdiff_t end = i;
    double sum = 0;
    for (; end < heard_to && parts[static_cast<std::size_t>(end)] == parts[static_cast<std::size_t>(i)]; ++end)
      sum += level_at(end);
    result.push_back({parts[static_cast<std::size_t>(i)], static_cast<double>(i) * kFrame,
                      static_cast<double>(end) * kFrame, sum / static_cast<double>(end - i)});
    i = end;
  }
  return result;
}

}  // namespace typodont::audio
