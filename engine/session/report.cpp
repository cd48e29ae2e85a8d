#include "engine/session/report.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/session/page/page.h"

namespace typodont::session {

SessionPicture read_picture(const std::filesystem::path& png, std::string_view name, std::string_view title) {
  const std::string bytes = read_input(png, InputKind::kPicture);
  SessionPicture picture{std::string(name), std::string(title), {bytes.begin(), bytes.end()}};
  static constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (picture.png.size() < 45 || std::memcmp(picture.png.data(), kSignature, 8) != 0) {
    throw Error(png.string(), "", "something else", "a PNG picture");
  }
  return picture;
}

ScoreInput score_input(const SessionReader& session, const HandMeasures& hand, const PerTissue& removed) {
  ScoreInput in;
  in.before = session.header().volumes_before;
  in.hand = hand;
  const auto& result = session.result();
  if (result && result->has_volumes) {
    in.after = result->volumes_after;
  } else {
    for (std::size_t i = 0; i < kTissueCount; ++i) in.after[i] = std::max(0.0, in.before[i] - removed[i]);
  }
  if (result && result->has_ideal) in.ideal = result->volumes_ideal;
  if (result && result->min_pulp_distance >= 0) in.pulp_distance = result->min_pulp_distance;
  return in;
}

Score score_session(const SessionReader& session) {
  const Course course = course_of(session);
  return score_of(session, score_input(session, course.hand, course.removed_total));
}

std::string report_html(const SessionReader& session, const ReportOptions& options) {
  return Page(session, options).html();
}

SessionSummary summarize(const SessionReader& session, std::optional<Score> score) {
  return {session.file().filename().string(),
          session.header().date,
          session.header().trainee,
          scene_name_of(session),
          session.truncated(),
          score ? std::move(*score) : score_session(session),
          task_title_of(session)};
}

}  // namespace typodont::session
