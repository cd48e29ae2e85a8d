// Pictures that a page shows, computed in the background. Changes during a computation are computed together
// afterwards. Main thread only.
#pragma once

#include <utility>
#include <vector>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class Preview {
 public:
  /// `pictures`: the page's pictures on the GPU. Empty: none is drawn yet, or the GPU device was created again.
  Preview(OperatorState& s, InterfaceWindow& w, std::vector<gpu::Image>& pictures)
      : s_(s), window_(w), pictures_(pictures) {}

  bool under_way() const { return job_.under_way(); }
  /// Shows the result of a computation that has ended. True: one has ended.
  bool look() { return job_.look(); }
  /// True if a computation must begin, because something has changed or no picture is shown. After a failure, only a
  /// change begins another one.
  bool due(bool changed) const { return !under_way() && (changed || (pictures_.empty() && !failed_)); }
  /// Begins a computation. `compute(progress)` runs on another thread; its result contains `pictures`. `take(result)`
  /// uses the other members; false: the result is old, and its pictures are not shown.
  template <class Compute, class Take>
  void begin(Compute compute, Take take) {
    failed_ = false;
    job_.make(
        std::move(compute),
        [this, take = std::move(take)](auto result) {
          if (take(result)) window_.replace(pictures_, result.pictures);
        },
        [this](const std::exception& e) {
          failed_ = true;
          s_.fail(e.what());
        });
  }
  /// Drops the computation and the pictures.
  void close() {
    job_.drop();
    failed_ = false;
    window_.replace(pictures_, {});
  }

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::vector<gpu::Image>& pictures_;
  bool failed_ = false;  // true: the last computation failed
  Job job_;
};

}  // namespace typodont
