// Shows a scan before its import: reads it, computes requested labels, draws sections. Main thread only.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/preview.h"
#include "engine/app/operator/state.h"

namespace typodont {

class ScanDesk {
 public:
  ScanDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work)
      : s_(s), work_(work), preview_(s, w, s.scan.pictures) {}

  /// Shows the page, and reads the scan of OperatorState::import in the background. If it can't be read, returns to the
  /// import page with the reason.
  void open();
  /// Takes over sections and tissue labels, executes ScanForm::changes, and starts what must be computed. Only the
  /// computation of labels at full size shows a progress bar. True: something visible has changed.
  bool look();
  /// Makes an exercise from the selected region of the scan with the user's corrections, and selects the exercise.
  void import(Choices& choices);
  /// Frees the memory of the scan.
  void close();

 private:
  void begin_coarse(const LabelRequest& request);
  void begin_full(const LabelRequest& request);

  OperatorState& s_;
  BackgroundTask& work_;
  std::optional<std::uint64_t> full_;  // revision for which work_ computes labels at full size
  bool import_asked_ = false;          // true: import() waits in ScanForm::changes
  Job coarse_;                         // computes coarse tissue labels
  Preview preview_;
  std::uint64_t drawn_ = 0;  // value of ScanReview::changes() when the last pictures were begun
};

}  // namespace typodont
