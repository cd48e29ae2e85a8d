// A scan in the window before its import: reads the scan, computes the labels that the review requests, and draws its
// sections. Main thread.
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

  /// Shows the page and reads the scan of OperatorState::import while the window continues. If the scan cannot be
  /// read, the page of imports is shown with the reason.
  void open();
  /// Takes computed labels and begins the computation of requested ones: coarse ones unnoticed, full ones as a task
  /// with progress. True if something visible changed.
  bool look();
  /// Draws the sections if they changed. Call before drawing the page.
  void follow();
  /// Makes an exercise of the region with its corrections, and selects the new scene.
  void import(Choices& choices);
  /// Destroys the pictures' GPU memory, e.g. of a lost device. The next follow() draws them again.
  void destroy();
  /// Frees the scan.
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
  std::optional<LabelRequest> full_;  // the request that work_ computes
  std::unique_ptr<Job> job_;          // computes coarse_
  std::vector<gpu::Image> images_;
  std::uint64_t drawn_ = 0;  // ScanReview::changes() of the pictures
};

}  // namespace typodont
