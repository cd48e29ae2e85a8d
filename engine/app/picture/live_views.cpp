#include "engine/app/picture/live_views.h"

#include <algorithm>
#include <chrono>

#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/realtime.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

// Longest time that one call of give() spends on passing mesh bricks to a picture, ns.
constexpr Nanos kGiveFor = 4'000'000;
constexpr Nanos kJudgeInterval = 2 * kNanosPerSecond;
// Time between two copies of the tissue, ns. A copy blocks the carver thread for some milliseconds.
constexpr Nanos kBodiesInterval = 120'000'000;
// Largest number of servo ticks of an exploration task that wait for their evaluation (ten minutes). Further ticks are
// lost.
constexpr std::size_t kMaxUnexplored = 600'000;

constexpr std::array kInsideColors = {render::kSectionFace, render::kSectionFaceAround, render::kInsidePulp,
                                      render::kInsideCaries, render::kInsideDentin};

}  // namespace

bool LiveViews::Wish::needs_bodies() const {
  return render::cuts_section(look.view) || look.view == render::View::kXray ||
         (look.view == render::View::kLook && look.hidden != 0);
}

LiveViews::LiveViews(const Scene& scene, const haptics::TissueVolume& tissue, const Surroundings& around,
                     Wiring& wiring, bool judged)
    : scene_(scene),
      wiring_(wiring),
      around_(around),
      judged_at_all_(judged),
      origin_W_(tissue.frame().origin),
      judging_(judged) {
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  middle_W_ = tissue.frame().to_world(0.5 * dvec3(lo + hi));
  const haptics::VoxelBox caries = tissue.box_of(Tissue::kCaries);
  section_W_ = caries.empty() ? middle_W_ : tissue.frame().to_world(0.5 * dvec3(caries.lo + caries.hi));
  const PerTissue volumes = tissue.volumes();
  for (std::size_t i = 1; i < volumes.size(); ++i)
    if (volumes[i] > 0) tissues_ |= 1u << i;
  if (judged) start();
}

void LiveViews::start() {
  if (!thread_.joinable()) thread_ = std::jthread([this] { run(); });
}

LiveViews::~LiveViews() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wished_.notify_all();
}

void LiveViews::all_again(Picture& picture) {
  picture.pending.clear();
  for (const auto& [key, update] : bricks_) picture.pending.push_back(key);
}

void LiveViews::attach(Eyes eyes, PictureStage* stage) {
  Picture& picture = pictures_[index(eyes)];
  picture.stage = stage;
  picture.pending.clear();
  picture.replaced = false;
  if (!stage) {
    const std::lock_guard lock(mutex_);
    wishes_[index(eyes)] = {};
    return;
  }
  ++picture.stages;
  all_again(picture);
  const Look wanted = picture.look;
  picture.look = {};
  picture.wish = {};
  picture.wish.stage = picture.stages;
  picture.made = true;
  look(eyes, wanted);
}

void LiveViews::take(MeshBatch batch) {
  for (render::MeshUpdate& update : batch) {
    for (Picture& picture : pictures_)
      if (picture.stage && !picture.replaced) picture.pending.push_back(update.brick);
    if (update.indices.empty())
      bricks_.erase(update.brick);
    else
      bricks_[update.brick] = std::move(update);
  }
}

/// Applies the picture's view and section plane, which need no result of the computing thread.
void LiveViews::show_as(Picture& p) {
  const bool difference = p.look.view == render::View::kDifference;
  p.stage->show_as(difference && !ideal_ ? render::View::kLook : p.look.view, p.wish.plane);
}

void LiveViews::look(Eyes eyes, const Look& wanted) {
  Picture& p = pictures_[index(eyes)];
  const Look before = p.look;
  p.look = wanted;
  if (!p.stage) return;
  if (wanted.surroundings != before.surroundings) {
    p.stage->surround(wanted.surroundings ? around_ : Surroundings());
    if (!wanted.surroundings) {
      p.stage->show_inside(render::kSectionFaceAround, {}, origin_W_);
      for (const SurroundingMesh& mesh : around_.meshes) p.stage->show_inside(mesh.id, {}, mesh.origin);
    }
    if (!p.replaced) all_again(p);  // sends all mesh bricks again, because the gum may have hidden some of them
  }
  Wish wish;
  wish.look.view = wanted.view;
  wish.stage = p.stages;
  if (render::cuts_section(wanted.view)) {
    wish.look.section_axis = wanted.section_axis;
    wish.look.section = wanted.section;
    wish.look.plane = wanted.plane;
    wish.look.surroundings = wanted.surroundings;
    wish.plane = section_plane(wanted, section_W_, p.stage->rig().head.eye_center);
  }
  if (wanted.view == render::View::kLook) wish.look.hidden = wanted.hidden;
  if (wish == p.wish) return;
  if (wish.look.view != p.wish.look.view)
    for (const render::MeshId body : kInsideColors) p.stage->show_inside(body, {}, origin_W_);
  if (p.replaced && wish.look.hidden == 0) {
    p.stage->show_inside(render::kWorkingTooth, {}, origin_W_);
    p.replaced = false;
    all_again(p);
  }
  if (wish.look.view == render::View::kDifference) all_again(p);
  p.wish = wish;
  p.made = !wish.needs_bodies() && (wish.look.view != render::View::kDifference || ideal_);
  show_as(p);
  {
    const std::lock_guard lock(mutex_);
    wishes_[index(eyes)] = wish;
  }
  if (!p.made) start();
  wished_.notify_all();
}

bool LiveViews::making(Eyes eyes) const {
  const Picture& p = pictures_[index(eyes)];
  return p.stage && !p.made;
}

bool LiveViews::give(Picture& p) {
  if (!p.stage || p.pending.empty()) return false;
  std::sort(p.pending.begin(), p.pending.end());
  p.pending.erase(std::unique(p.pending.begin(), p.pending.end()), p.pending.end());
  const Nanos until = now() + kGiveFor;
  const bool mark = p.wish.look.view == render::View::kDifference && ideal_;
  while (!p.pending.empty() && now() < until) {
    std::vector<render::MeshUpdate> some;
    while (!p.pending.empty() && some.size() < 16) {
      const auto found = bricks_.find(p.pending.back());
      some.push_back(found != bricks_.end() ? found->second : render::MeshUpdate{p.pending.back(), {}, {}});
      p.pending.pop_back();
    }
    if (mark) mark_difference(*ideal_, origin_W_, some);
    p.stage->show(some, origin_W_);
  }
  return true;
}

bool LiveViews::advance() {
  std::vector<Made> made;
  {
    const std::lock_guard lock(mutex_);
    made.swap(made_);
    if (gave_up_) judging_ = false;
    if (fresh_judged_) {
      judged_ = std::exchange(fresh_judged_, std::nullopt);
      judged_version_ = fresh_version_;
    }
    if (fresh_explore_) explore_ = std::exchange(fresh_explore_, std::nullopt);
    if (fresh_ideal_) ideal_ = std::move(fresh_ideal_);
  }
  bool gave = false;
  for (Picture& p : pictures_) {
    if (!p.stage || p.made || p.wish.look.view != render::View::kDifference || !ideal_) continue;
    p.made = true;
    all_again(p);
    show_as(p);
  }
  for (Made& m : made) {
    Picture& p = pictures_[index(m.eyes)];
    // The user requested another Look during this computation, so the result is not used.
    if (!p.stage || !(m.wish == p.wish)) continue;
    for (const ViewBody& body : m.bodies) {
      p.stage->show_inside(body.mesh, body.bricks, origin_W_);
      if (body.mesh != render::kWorkingTooth) continue;
      p.replaced = true;
      p.pending.clear();
    }
    p.made = true;
    gave = true;
  }
  for (Picture& p : pictures_) gave |= give(p);
  return gave;
}

void LiveViews::explore(const ServoTick& tick) {
  if (!scene_.task || !scene_.task->explore) return;
  if (!explore_) {
    if (unexplored_.size() < kMaxUnexplored) unexplored_.push_back(tick);
    return;
  }
  if (!unexplored_.empty()) explore_->add(std::exchange(unexplored_, {}));
  explore_->add({&tick, 1});
  if (judged_) judged_->explore = explore_->result();
}

std::pair<std::optional<session::ExploreMeter>, std::vector<ServoTick>> LiveViews::take_explored() {
  return {std::exchange(explore_, std::nullopt), std::exchange(unexplored_, {})};
}

/// Requests a copy of the current tissue from the carver thread and waits for it. Returns null if the session ends
/// first.
std::unique_ptr<haptics::TissueVolume> LiveViews::copy_of_tissue() {
  wiring_.copy_wanted = true;
  while (true) {
    haptics::TissueVolume* copy = nullptr;
    if (wiring_.copies_to_watch.pop(copy)) return std::unique_ptr<haptics::TissueVolume>(copy);
    {
      const std::lock_guard lock(mutex_);
      if (stop_ || wiring_.stop) return nullptr;
    }
    std::this_thread::sleep_for(1ms);
  }
}

void LiveViews::run() {
  lower_priority();
  std::optional<TaskEvaluator> judge;
  PerTissue before{};
  if (judged_at_all_) try {
      const haptics::TissueVolume start = load_untouched(scene_);
      before = start.volumes();
      judge.emplace(scene_, start);
      const std::lock_guard lock(mutex_);
      fresh_explore_ = judge->explore_meter();
    } catch (const Error& e) {
      log::warn("no score while the session runs: {}", e.what());
      const std::lock_guard lock(mutex_);
      gave_up_ = true;
    }

  constexpr std::uint64_t kNever = ~std::uint64_t{0};
  // For each of the two pictures: the view settings for which its content was last computed.
  std::array<Wish, 2> shown;
  std::array<std::uint64_t, 2> shown_version{kNever, kNever};  // version of the tissue when `shown` was computed
  std::array<Nanos, 2> bodies_due{0, 0};
  std::uint64_t judged_version = kNever;
  Nanos judge_due = 0;
  bool ideal_made = false;
  // Distance functions of the tooth's surroundings. Created when the first section is requested, because this takes
  // time and memory.
  std::optional<SurroundingsShape> surroundings;
  while (true) {
    std::array<Wish, 2> wishes;
    {
      std::unique_lock lock(mutex_);
      const bool follows = std::any_of(shown.begin(), shown.end(), [](const Wish& w) { return w.needs_bodies(); });
      wished_.wait_for(lock, follows ? 25ms : 100ms, [&] { return stop_ || !(wishes_ == shown); });
      if (stop_) return;
      wishes = wishes_;
    }
    if (can_show(render::View::kDifference) && !ideal_made &&
        std::any_of(wishes.begin(), wishes.end(),
                    [](const Wish& w) { return w.look.view == render::View::kDifference; })) {
      ideal_made = true;
      try {
        const auto own = judge ? std::nullopt : ideal_tissue(scene_, load_untouched(scene_));
        auto field = std::make_shared<const ToothField>(judge ? *judge->ideal() : own.value(), kDifferenceReach);
        const std::lock_guard lock(mutex_);
        fresh_ideal_ = std::move(field);
      } catch (const std::exception& e) {
        log::warn("no difference to an ideal: {}", e.what());
      }
    }
    const std::uint64_t version = wiring_.tissue_version;
    std::array<bool, 2> make{}, around{};
    for (std::size_t i = 0; i < 2; ++i) {
      const bool other = !(wishes[i] == shown[i]);
      make[i] = wishes[i].needs_bodies() && (other || (version != shown_version[i] && now() >= bodies_due[i]));
      around[i] =
          other && wishes[i].look.view == render::View::kSection && wishes[i].look.surroundings && has_surroundings();
      if (other && !make[i]) shown[i] = wishes[i];
    }
    const bool judging = judge && version != judged_version && now() >= judge_due;
    if (!make[0] && !make[1] && !judging) continue;
    const auto tissue = copy_of_tissue();
    if (!tissue) return;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!make[i]) continue;
      const Nanos began = now();
      Made made{static_cast<Eyes>(i), wishes[i],
                view_bodies(wishes[i].look.view, wishes[i].plane, wishes[i].look.hidden, *tissue)};
      shown[i] = wishes[i];
      shown_version[i] = version;
      bodies_due[i] = now() + std::max(kBodiesInterval, now() - began);
      keep(std::move(made));
    }
    // The surroundings' sections are computed after the tooth's result, which is more important.
    for (std::size_t i = 0; i < 2; ++i) {
      if (!around[i]) continue;
      try {
        if (!surroundings) surroundings = surroundings_shape(scene_.surroundings);
        const glm::dvec4& plane = wishes[i].plane;
        Made made{static_cast<Eyes>(i),
                  wishes[i],
                  {{render::kSectionFaceAround, surroundings->section_face(dvec3(plane), -plane.w, origin_W_)}}};
        keep(std::move(made));
      } catch (const std::exception& e) {
        log::warn("no section of what stands around the tooth: {}", e.what());
      }
    }
    if (!judging) continue;
    const Nanos began = now();
    session::ScoreInput input;
    try {
      input.before = before;
      input.after = tissue->volumes();
      (void)judge->judge(*tissue, input);
    } catch (const std::exception& e) {
      log::warn("no score while the session runs: {}", e.what());
      judge.reset();
      const std::lock_guard lock(mutex_);
      gave_up_ = true;
      continue;
    }
    judged_version = version;
    judge_due = now() + std::max(kJudgeInterval, now() - began);
    const std::lock_guard lock(mutex_);
    fresh_judged_ = std::move(input);
    fresh_version_ = version;
  }
}

/// Stores a result for the render thread. Replaces an older result for the same picture that was not used yet.
void LiveViews::keep(Made made) {
  const std::lock_guard lock(mutex_);
  std::erase_if(made_,
                [&](const Made& old) { return old.eyes == made.eyes && old.bodies[0].mesh == made.bodies[0].mesh; });
  made_.push_back(std::move(made));
}

}  // namespace typodont
