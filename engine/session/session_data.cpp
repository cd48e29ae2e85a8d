#include "engine/session/session_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>

namespace typodont::session {

std::string SessionHeader::compiler_of_this_build() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

std::string iso_date_now() {
  const std::time_t t = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&t, &utc);
  return fmt::format("{:04d}-{:02d}-{:02d}T{:02d}:{:02d}:{:02d}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec);
}

std::optional<LocalTime> local_time(const std::string& iso) {
  std::tm utc{}, local{};
  const char* end = strptime(iso.c_str(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  if (!end || *end != '\0') return std::nullopt;
  const std::time_t t = timegm(&utc);
  if (!localtime_r(&t, &local)) return std::nullopt;
  const long minutes = std::abs(local.tm_gmtoff) / 60;
  return LocalTime{fmt::format("{:04d}-{:02d}-{:02d} {:02d}:{:02d}", local.tm_year + 1900, local.tm_mon + 1,
                               local.tm_mday, local.tm_hour, local.tm_min),
                   fmt::format("UTC{}{:02d}:{:02d}", local.tm_gmtoff < 0 ? '-' : '+', minutes / 60, minutes % 60)};
}

std::string in_words(const Lost& l) {
  std::string text;
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(l.ticks_ring + l.ticks_disk, "ticks");
  add(l.cuts_ring + l.cuts_disk, "cuts");
  add(l.pictures_disk, "pictures");
  add(l.other_ring + l.other_disk, "other entries");
  return text;
}

std::string in_words(const std::vector<Gap>& gaps) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(gaps.size(), kNamed); ++i) {
    const Gap& gap = gaps[i];
    text += fmt::format("{}{:.3f} s to {:.3f} s ({} ticks, {} cuts)", i ? ", " : "", to_seconds(gap.from),
                        to_seconds(gap.to), gap.ticks, gap.cuts);
  }
  if (gaps.size() > kNamed) text += fmt::format(" and {} more", gaps.size() - kNamed);
  return text;
}

std::string_view name_of(EventKind kind) noexcept {
  static constexpr std::array<std::string_view, kEventKindCount> kNames = {"note", "tool", "view",  "fault", "task",
                                                                           "undo", "redo", "score", "piece"};
  const auto i = static_cast<std::size_t>(kind);
  return i < kNames.size() ? kNames[i] : "unknown";
}

}  // namespace typodont::session
