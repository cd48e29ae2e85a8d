// Shows a scan before its import: reads it, computes requested labels, draws sections. Main thread only.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/scan_review.h"

namespace typodont {

class ScanDesk {
 public:
  ScanDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work) : s_(s), work_(work), pictures_(w) {}

  /// Shows the page, and reads the scan of OperatorState::import in the background. If it can't be read, returns to the
  /// import page with the reason.
  void open();
  /// Takes over computed tissue labels, and starts the computation of requested ones. Only the computation of labels at
  /// full size shows a progress bar. True: something visible has changed.
  bool look();
  /// Redraws changed sections. Call before the page is drawn.
  void follow();
  /// Makes an exercise from the selected region of the scan with the user's corrections, and selects the exercise.
  void import(Choices& choices);
  /// Frees the GPU memory of the pictures; the next follow() creates them again.
  void destroy();
  /// Frees the memory of the scan.
  void close();

 private:
  void begin_coarse(const LabelRequest& request);
  void begin_full(const LabelRequest& request);

  OperatorState& s_;
  BackgroundTask& work_;
  std::unique_ptr<ScanReview> review_;
  struct Computed {
    LabelRequest request;
    std::optional<haptics::Imported> labels;
  };
  std::shared_ptr<Computed> coarse_;
  std::optional<LabelRequest> full_;  // labels at full size that work_ computes
  std::unique_ptr<Job> job_;          // computes the coarse tissue labels that `coarse_` requests
  UploadedPictures pictures_;
  std::uint64_t drawn_ = 0;  // value of ScanReview::changes() when the pictures were drawn
};

}  // namespace typodont
