#include "engine/app/recording/stream_check.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/session/compare.h"

namespace typodont {

namespace {
constexpr double kPeriodError = 0.02;  // largest accepted relative error of the tick period; real clocks deviate less
}

StreamCheck::StreamCheck(const session::SessionReader& session)
    : session_(session), last_tick_(session.gaps().empty() ? UINT64_MAX : session.gaps().front().after_tick) {}

void StreamCheck::differs(std::uint64_t tick, std::string what) {
  if (!difference_) difference_ = {tick, std::move(what)};
}

void StreamCheck::volumes(const PerTissue& replayed, const PerTissue& recorded, const char* when) {
  // Largest relative difference between a recorded and a replayed volume that counts as equal. The file stores mm³, so
  // numbers are rounded when they are written and when they are read.
  constexpr double kRounding = 1e-12;
  for (std::size_t i = 1; i < replayed.size(); ++i) {
    if (std::abs(replayed[i] - recorded[i]) > kRounding * std::abs(recorded[i]))
      differs(now_, fmt::format("the volume of {} {}", name_of(static_cast<Tissue>(i)), when));
  }
}

void StreamCheck::volumes_at_start(const PerTissue& replayed) {
  volumes(replayed, session_.header().volumes_before, "at the start");
}

void StreamCheck::tick(const ServoTick& replayed, const ServoTick& recorded) {
  now_ = recorded.index;
  if (last_ && (replayed.depth > 0 || replayed.contact_area > 0)) {
    const double period = to_seconds(recorded.t - last_->t) * session_.header().servo_rate;
    ++contact_ticks_, contact_time_ += period;
    if (period < 1 - kPeriodError) ++early_;
    if (period > 1 + kPeriodError) ++late_;
  }
  last_ = recorded;
  if (difference_) return;
  const std::string_view column = session::differing_column(replayed, recorded);
  if (column.empty()) return;
  const bool force = column.starts_with("force_") || column.starts_with("torque_");
  differs(now_, fmt::format("{} at tick {}", force ? "force" : column, now_));
}

void StreamCheck::cut(const Cut& replayed) {
  if (difference_) return;
  const auto& cuts = session_.cuts();
  if (cut_ >= cuts.size() || cuts[cut_].index != replayed.index)
    return differs(now_, fmt::format("cut {}, which the recording lacks,", replayed.index));
  const std::string_view column = session::differing_column(replayed, cuts[cut_++]);
  if (!column.empty()) differs(now_, fmt::format("{} of cut {}", column, replayed.index));
}

void StreamCheck::rate() {
  // The rate is wrong only if both the mean and the median of the period deviate: single late ticks do not change the
  // median, and jitter does not change the mean.
  const double ticks = static_cast<double>(contact_ticks_);
  if ((2 * early_ > contact_ticks_ && contact_time_ < (1 - kPeriodError) * ticks) ||
      (2 * late_ > contact_ticks_ && contact_time_ > (1 + kPeriodError) * ticks))
    differs(now_, fmt::format("the rate of {} Hz, from the times of ticks in contact,", session_.header().servo_rate));
}

void StreamCheck::end(const haptics::TissueVolume& tissue) {
  const auto& cuts = session_.cuts();
  rate();
  if (!session_.gaps().empty())
    differs(last_tick_, fmt::format("what follows tick {} is not checked: the recording has gaps, {}", last_tick_,
                                    in_words(session_.gaps())));
  // An interrupted recording may contain cuts whose ticks are missing. Such cuts are not compared.
  if (cut_ < cuts.size() && (!session_.truncated() || cuts[cut_].tick <= now_))
    differs(cuts[cut_].tick, fmt::format("cut {}, which the replay does not make,", cuts[cut_].index));
  const auto& result = session_.result();
  if (!result) return;
  if (result->has_volumes) volumes(tissue.volumes(), result->volumes_after, "at the end");
  if (result->field_hash != 0 && result->field_hash != tissue.hash()) differs(now_, "the tissue at the end");
}

}  // namespace typodont
