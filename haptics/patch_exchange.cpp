#include "haptics/patch_exchange.h"

namespace typodont::haptics {

namespace {

// Longest time that a new tissue patch waits for missing cuts, ns. A cutting hand moves less than 0.25 mm in 5 ms.
constexpr Nanos kPatience = 5'000'000;

}  // namespace

void PatchExchange::offer(Carver& carver, const dvec3& center_W) {
  way_.take_returned();
  Snapshot& fresh = *way_.back();
  // While a patch is offered, it is unknown which patch the servo holds. Then a complete snapshot (0) is taken.
  carver.take_snapshot(center_W, fresh, 0, offered_ == 0 ? held_ : 0);
  offered_ = fresh.number;
  offered_step_ = fresh.from != 0;
  offered_cuts_ = fresh.cuts;
  offered_tissue_ = tissue_of(fresh);
  way_.publish();
  carver.remember_writes(offered_tissue_ == held_tissue_);
}

bool PatchExchange::keep_up(Carver& carver, std::uint32_t held) {
  if (offered_ == 0) return false;
  if (held == offered_) {
    held_tissue_ = offered_tissue_;
    held_ = offered_;
    offered_ = 0;
    carver.remember_writes(false);
    return false;
  }
  if (!offered_step_ && offered_tissue_ == held_tissue_ && carver.cuts() > offered_cuts_ && way_.take_back()) {
    if (carver.bring_up_to_date(*way_.back())) offered_cuts_ = carver.cuts();
    way_.publish();
  }
  return true;
}

Snapshot* PatchExchange::take(const Snapshot& held, std::uint64_t cuts, Nanos t) noexcept {
  if (adopted_) way_.hand_back();
  adopted_ = false;
  while (way_.fetch()) {
    Snapshot& fresh = *way_.front();
    const bool complete =
        held.number == 0 || fresh.from != 0 || fresh.cuts >= cuts || tissue_of(fresh) != tissue_of(held);
    if (waiting_since_ == 0) waiting_since_ = t;
    if (complete || t - waiting_since_ >= kPatience) {
      waiting_since_ = 0;
      adopted_ = true;
      taken_.store(fresh.number, std::memory_order_release);
      return &fresh;
    }
    // give_back() fails if a newer tissue patch has arrived; the next pass of the loop takes it.
    if (way_.give_back()) break;
  }
  return nullptr;
}

}  // namespace typodont::haptics
