#include "engine/app/recording/file_source.h"

#include <algorithm>
#include <cmath>

#include "engine/app/recording.h"
#include "engine/app/surroundings/soft_gum.h"

namespace typodont {

namespace {

// Stiffness of the tool, N/m. The recorded poses include its displacement by the gum; with this large stiffness, the
// gum does not displace it a second time.
constexpr double kRigid = 1e6;
constexpr std::uint64_t kBlock = 4096;  // number of ticks that are read from the file, or written, at a time

}  // namespace

FileSource::FileSource(const session::SessionReader& session, const Scene& scene)
    : session_(session),
      scene_(scene),
      surface_(soft_gum(scene.surroundings)),
      water_(session.stream("water")),
      left_hand_(session.stream("left_hand")) {
  for (const session::SessionEvent& event : session.events())
    if (const auto piece = piece_of(event)) pieces_.push_back(*piece);
  rewind();
}

void FileSource::rewind() {
  tick_ = 0;
  cut_ = piece_ = switch_ = left_ = 0;
  if (!surface_) return;
  gum_.emplace(surface_, haptics::tool_set(scene_.servo), kRigid);
  gum_writer_.emplace(&*gum_, event_logs_->servo, session_.header().servo_rate);
}

bool FileSource::advance(Nanos t) {
  const std::uint64_t first = tick_;
  Nanos end = t;
  for (const ServoTick* tick; (tick = next_tick()) && tick_ < first + kBlock; ++tick_) {
    if (tick->t > end && tick_ > 0) break;
    if (tick_ == first) end = std::min(t, tick->t + kNanosPerSecond);
    write_before(tick->t);
    if (gum_) press(*tick);
    event_logs_->servo.write(*tick);
  }
  return tick_ != first;
}

/// The file's next tick; null at the session's end.
const ServoTick* FileSource::next_tick() {
  if (tick_ >= session_.tick_count()) return nullptr;
  if (tick_ < block_first_ || tick_ >= block_first_ + block_.size()) {
    block_ = session_.ticks(tick_, kBlock);
    block_first_ = tick_;
  }
  return &block_[tick_ - block_first_];
}

/// Writes all events up to the time t, except ticks, to the event logs.
void FileSource::write_before(Nanos t) {
  const auto& cuts = session_.cuts();
  for (; cut_ < cuts.size() && cuts[cut_].t <= t; ++cut_) event_logs_->servo.write(cuts[cut_]);
  for (; piece_ < pieces_.size() && pieces_[piece_].t <= t; ++piece_) event_logs_->carver.write(pieces_[piece_]);
  for (; water_ && switch_ < water_->t.size() && water_->t[switch_] <= t; ++switch_) {
    const auto& c = water_->columns;
    event_logs_->view.write(WaterSwitch{water_->t[switch_], c[0][switch_] != 0, c[1][switch_] != 0});
  }
  for (; left_hand_ && left_ < left_hand_->t.size() && left_hand_->t[left_] <= t; ++left_) {
    const auto& c = left_hand_->columns;
    haptics::HandSample sample;
    sample.t = left_hand_->t[left_];
    sample.X_WT = {{c[0][left_], c[1][left_], c[2][left_]},
                   glm::normalize(dquat(c[3][left_], c[4][left_], c[5][left_], c[6][left_]))};
    event_logs_->left.write(sample);
  }
}

void FileSource::press(const ServoTick& tick) {
  const auto tools = haptics::tool_set(scene_.servo);
  if (tick.tool < tools.size() && is_finite(tick.X_WG.p) && !gum_->at_rest(tick.X_WG, tick.tool)) {
    const haptics::Tool& tool = tools[tick.tool];
    const double cutting = tool.turns() ? tool.cutting_coefficient * std::abs(tick.spindle) * tool.radius() : 0.0;
    gum_->tick({tick.t, 1 / session_.header().servo_rate, tick.X_WG, tick.tool, cutting});
  }
  gum_writer_->tick();
}

}  // namespace typodont
