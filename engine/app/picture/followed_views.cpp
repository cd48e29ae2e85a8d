#include "engine/app/picture/followed_views.h"

#include "engine/app/picture/teaching_views.h"

namespace typodont {

namespace {

constexpr Nanos kInterval = 120'000'000;  // ns between copies: a copy keeps the carver from its patches for some ms

bool has_bodies(render::View view) { return view == render::View::kSection || view == render::View::kXray; }

}  // namespace

FollowedViews::FollowedViews() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

FollowedViews::~FollowedViews() {
  thread_.request_stop();
  ready_.notify_all();
}

void FollowedViews::want(render::View view, const glm::dvec4& section) {
  const std::lock_guard lock(mutex_);
  wanted_ = {view, section, wanted_.number + 1};
  done_ = false;
  wanting_ = has_bodies(view);
}

void FollowedViews::offer(const haptics::TissueVolume& tissue, std::uint64_t state) {
  if (!wanting_.load(std::memory_order_relaxed) || !idle_.load(std::memory_order_acquire)) return;
  const Nanos t = now();
  if (t - offered_ < kInterval) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || (state == offered_state_ && wanted_.number == offered_number_)) return;
  offered_ = t;
  offered_state_ = state;
  offered_number_ = wanted_.number;
  handed_ = std::make_unique<haptics::TissueVolume>(tissue.clone());
  idle_ = false;
  ready_.notify_all();
}

bool FollowedViews::take(Bodies& bodies) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || !done_) return false;
  done_ = false;
  bodies = std::move(bodies_);
  return true;
}

void FollowedViews::work(const std::stop_token& stop) {
  for (;;) {
    Task task;
    std::unique_ptr<haptics::TissueVolume> tissue;
    {
      std::unique_lock lock(mutex_);
      if (!ready_.wait(lock, stop, [&] { return handed_ != nullptr; })) return;
      task = wanted_;
      tissue = std::move(handed_);
    }
    Bodies bodies;
    if (task.view == render::View::kSection) {
      bodies.emplace_back(render::kSectionFace, section_face(*tissue, dvec3(task.section), -task.section.w));
    } else if (task.view == render::View::kXray) {
      bodies.emplace_back(render::kInsidePulp, tissue_inside(*tissue, Tissue::kPulp));
      bodies.emplace_back(render::kInsideCaries, tissue_inside(*tissue, Tissue::kCaries));
      bodies.emplace_back(render::kInsideDentin, tissue_inside(*tissue, Tissue::kDentin));
    }
    const std::lock_guard lock(mutex_);
    if (task.number == wanted_.number) {
      bodies_ = std::move(bodies);
      done_ = true;
    }
    idle_ = true;
  }
}

}  // namespace typodont
