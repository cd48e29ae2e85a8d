// A scan before its import: reads it, computes requested labels, draws sections. Main thread only.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/scan_review.h"

namespace typodont {

class ScanDesk {
 public:
  ScanDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work) : s_(s), window_(w), work_(work) {}
  ~ScanDesk() { destroy(); }
  ScanDesk(const ScanDesk&) = delete;
  ScanDesk& operator=(const ScanDesk&) = delete;

  /// Shows the page, reads OperatorState::import in the background. If unreadable: back to the import page, with the
  /// reason.
  void open();
  /// Takes finished labels and starts requested ones: coarse ones silently, full ones with a progress bar. True:
  /// something visible changed.
  bool look();
  /// Redraws after a change, before the page is drawn.
  void follow();
  /// An exercise from the region with the corrections; selects it.
  void import(Choices& choices);
  /// GPU memory of the pictures; the next follow() creates them again.
  void destroy();
  /// The scan's memory.
  void close();

 private:
  void begin_coarse(const LabelRequest& request);
  void begin_full(const LabelRequest& request);

  OperatorState& s_;
  InterfaceWindow& window_;
  BackgroundTask& work_;
  std::unique_ptr<ScanReview> review_;
  struct Computed {
    LabelRequest request;
    std::optional<haptics::Imported> labels;
  };
  std::shared_ptr<Computed> coarse_;
  std::optional<LabelRequest> full_;  // labels at full size that work_ computes
  std::unique_ptr<Job> job_;          // computes coarse tissue labels (the request `coarse_`)
  std::vector<gpu::Image> images_;
  std::uint64_t drawn_ = 0;  // value of ScanReview::changes() when the pictures were drawn
};

}  // namespace typodont
