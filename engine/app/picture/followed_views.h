// Views for teaching that follow the cut while it happens. What a section shows on its face and what lies inside the
// tooth is worked out on a thread of its own, from a copy of the tissue that the carver hands over; neither the servo
// nor the picture ever waits for it. Nothing wanted: no copy, no work.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class FollowedViews {
 public:
  /// What a view shows beside the surface, at a moment of the cut.
  using Bodies = std::vector<std::pair<render::MeshId, std::vector<render::MeshUpdate>>>;

  FollowedViews();
  ~FollowedViews();
  FollowedViews(const FollowedViews&) = delete;
  FollowedViews& operator=(const FollowedViews&) = delete;

  /// Drawing thread. `section` as in render::Frame.
  void want(render::View view, const glm::dvec4& section);
  /// Carver's thread, often: hands a copy over when one is wanted, the tissue is not the one handed over last, and the
  /// last is done with. `state`: a number that differs when the tissue does.
  void offer(const haptics::TissueVolume& tissue, std::uint64_t state);
  /// Drawing thread: what has become ready for the view wanted; true at most once for each.
  bool take(Bodies& bodies);

 private:
  struct Task {
    render::View view = render::View::kLook;
    glm::dvec4 section{0, 0, 0, 1};
    std::uint64_t number = 0;  // of the wish
  };
  void work(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any ready_;
  Task wanted_;
  std::unique_ptr<haptics::TissueVolume> handed_;
  Bodies bodies_;
  bool done_ = false;
  std::atomic<bool> idle_{true}, wanting_{false};
  // Carver's thread:
  std::uint64_t offered_state_ = 0, offered_number_ = 0;
  Nanos offered_ = 0;
  std::jthread thread_;  // last: it refers to all of the above
};

}  // namespace typodont
