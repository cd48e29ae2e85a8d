// A Job whose progress and failure the page shows. Main thread only.
#pragma once

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class BackgroundTask : public Job {
 public:
  explicit BackgroundTask(OperatorState& s) : s_(s) {}

  /// Cancels the task and waits for its end.
  void drop();
  /// Updates the progress. After a failure, shows the reason. True: the task has just ended.
  bool look();

 private:
  OperatorState& s_;
};

}  // namespace typodont
