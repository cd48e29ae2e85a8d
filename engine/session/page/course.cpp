#include "engine/session/page/course.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/contract/safety_event.h"
#include "engine/session/session_data.h"

namespace typodont::session {

namespace {

constexpr std::size_t kBins = 480;  // number of bins in plots over time
// ns, time over which speed is averaged, to reduce encoder noise
constexpr Nanos kSpeedOver = 20'000'000;
// s, a shorter pause does not end a fault, because a force near its limit leaves the limit often
constexpr double kFaultPause = 0.5;

void count_fault(Course::FaultCount& fault, double t) {
  if (fault.ticks++ == 0) fault.first = t;
  if (fault.times == 0 || t - fault.last > kFaultPause) ++fault.times;
  fault.last = t;
}

struct Accumulator {
  std::vector<double> least, sum, greatest;
  std::vector<std::uint64_t> count;
  explicit Accumulator(std::size_t n) : least(n, 1e300), sum(n, 0), greatest(n, -1e300), count(n, 0) {}
  void add(std::size_t bin, double v) {
    if (!std::isfinite(v)) return;
    least[bin] = std::min(least[bin], v);
    greatest[bin] = std::max(greatest[bin], v);
    sum[bin] += v;
    ++count[bin];
  }
  Series series() const {
    Series s;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const bool some = count[i] > 0;
      s.least.push_back(some ? least[i] : std::nan(""));
      s.mean.push_back(some ? sum[i] / static_cast<double>(count[i]) : std::nan(""));
      s.greatest.push_back(some ? greatest[i] : std::nan(""));
    }
    return s;
  }
};

}  // namespace

Course course_of(const SessionReader& session) {
  Course c;
  const double rate = session.header().servo_rate;
  c.count = session.tick_count();
  c.faults.resize(fault_names().size());
  if (c.count > 0) {
    c.t0 = static_cast<double>(session.ticks(0, 1).front().index) / rate;
    c.t1 = static_cast<double>(session.ticks(c.count - 1, 1).front().index) / rate;
  }
  if (!(c.t1 > c.t0)) c.t1 = c.t0 + 1;
  const std::size_t bins = std::clamp<std::size_t>(c.count, 1, kBins);
  Accumulator force(bins), speed(bins), spindle(bins), depth(bins), removed(bins);
  std::optional<ServoTick> moved_from;
  c.touched.resize(bins);
  HandMeter meter(rate);
  session.each_piece([&](std::vector<ServoTick> ticks) {
    set_scored_times(ticks, rate);
    meter.add(ticks);
    for (const ServoTick& tick : ticks) {
      const double t = to_seconds(tick.t);
      const double place = (t - c.t0) / (c.t1 - c.t0) * static_cast<double>(bins);
      const auto bin = static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(bins - 1)));
      force.add(bin, glm::length(tick.f_T_W));
      depth.add(bin, tick.depth * 1e3);
      spindle.add(bin, std::abs(tick.spindle) * 60 / (2 * kPi) / 1e3);
      c.max_spindle = std::max(c.max_spindle, std::abs(tick.spindle) * 60 / (2 * kPi) / 1e3);
      if (!moved_from || tick.t - moved_from->t >= kSpeedOver) {
        if (moved_from)
          speed.add(bin, glm::length(tick.X_WT.p - moved_from->X_WT.p) * 1e3 / to_seconds(tick.t - moved_from->t));
        moved_from = tick;
      }
      removed.add(bin, total(tick.removed) * 1e9);
      if (tick.depth > 0 || tick.contact_area > 0) ++c.touched[bin][static_cast<std::size_t>(tick.tissue)];
      for (std::size_t i = 0; i < c.faults.size(); ++i) {
        if (tick.faults & bits(fault_names()[i].fault)) count_fault(c.faults[i], t);
      }
      if (tick.faults & ~bits(Fault::kHeld)) count_fault(c.all_faults, t);
      if (tick.cpu_time > 0) c.cpu_us.push_back(static_cast<float>(static_cast<double>(tick.cpu_time) / 1e3));
      c.removed_total = tick.removed;
    }
  });
  c.force = force.series();
  c.speed = speed.series();
  c.spindle = spindle.series();
  c.depth = depth.series();
  c.removed = removed.series();
  c.hand = meter.result();
  return c;
}

Score score_of(const SessionReader& session, const ScoreInput& input) {
  if (session.header().scene_json.empty()) return score(input, default_rules(input));
  const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
  Score result = score_of_scene(scene, input);
  if (!scene.is_object() || !scene.find("task")) return result;
  for (ScoreItem& item : result.items) item.points = item.full = 0;
  result.points = result.full = 0;
  return result;
}

std::string scene_name_of(const SessionReader& session) {
  if (session.header().scene_json.empty()) return "";
  const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
  return scene.is_object() ? scene.string_or("name", "") : "";
}

TaskText task_title_of(const SessionReader& session) {
  if (session.header().scene_json.empty()) return {};
  const Json scene = Json::parse(session.header().scene_json, session.file().string() + ": scene");
  const auto task = scene.is_object() ? scene.find("task") : std::nullopt;
  const auto title = task && task->is_object() ? task->find("title") : std::nullopt;
  return title ? read_task_text(*title) : TaskText{};
}

}  // namespace typodont::session
