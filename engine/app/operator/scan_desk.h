// Shows a scan in the window before its import. Reads the scan, computes the tissue labels that the review requests,
// and draws its sections. Main thread only.
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

  /// Shows the page and reads the scan of OperatorState::import in the background. If the scan cannot be read, the
  /// import page is shown with the reason.
  void open();
  /// Receives tissue labels when their computation has ended, and starts the computation of requested labels. Coarse
  /// labels are computed without a message to the user. Full labels (with the scan's own voxel size) are computed as a
  /// task with a progress bar. Returns true if something visible changed.
  bool look();
  /// Draws the sections again if they have changed. Call it before the page is drawn.
  void follow();
  /// Makes an exercise from the selected region of the scan, with the user's corrections, and selects the new scene.
  void import(Choices& choices);
  /// Frees the GPU memory of the pictures, for example after the GPU was lost. The next follow() creates them again.
  void destroy();
  /// Frees the memory of the scan.
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
  std::optional<LabelRequest> full_;  // request for labels with the scan's own voxel size, computed by work_ at present
  std::unique_ptr<Job> job_;          // computes coarse tissue labels (the request `coarse_`)
  std::vector<gpu::Image> images_;
  std::uint64_t drawn_ = 0;  // value of ScanReview::changes() when the pictures were drawn
};

}  // namespace typodont
